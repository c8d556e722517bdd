//! Decomposes the 3x3 matrices on standard input: the core's eigen-solver for programs in other languages.
//!
//! A matrix is its lower triangle by rows, six `f32`, little endian; the answer is three eigenvalues and three eigenvectors.
//! With the argument `correlation`, matrices are taken for correlation matrices. See `references/eigen_families.py`.

use std::io::{self, BufReader, BufWriter, ErrorKind, Read, Write};

use monitor_core::eigen::ClosedFormEigen;
use nalgebra::Matrix3;

fn main() -> io::Result<()> {
    let correlation = match std::env::args().nth(1).as_deref() {
        None => false,
        Some("correlation") => true,
        Some(other) => {
            let usage = format!("unknown argument {other:?}; usage: decompose [correlation] < matrices > answers");
            return Err(io::Error::new(ErrorKind::InvalidInput, usage));
        }
    };
    let mut input = BufReader::new(io::stdin().lock());
    let mut output = BufWriter::new(io::stdout().lock());
    let mut record = [0; 24];
    loop {
        match input.read_exact(&mut record) {
            Ok(()) => {}
            Err(error) if error.kind() == ErrorKind::UnexpectedEof => return output.flush(),
            Err(error) => return Err(error),
        }
        let mut words = record.chunks_exact(4).map(|word| f32::from_le_bytes([word[0], word[1], word[2], word[3]]));
        let [a, b, c, d, e, f] = std::array::from_fn(|_| words.next().unwrap_or(f32::NAN));
        let matrix = Matrix3::new(a, b, d, b, c, e, d, e, f);
        let found = if correlation { matrix.decompose_correlation() } else { matrix.decompose() };
        let found = found.checked().map_err(|error| io::Error::new(ErrorKind::InvalidData, format!("{error:?}")))?;
        for number in found.values.iter().chain(found.vectors.iter()) {
            output.write_all(&number.to_le_bytes())?;
        }
    }
}

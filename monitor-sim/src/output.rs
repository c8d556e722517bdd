//! Files that are whole or not there: written beside their place, then moved into it.

use std::fs::{self, File};
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use tempfile::TempPath;

/// Why something could not be written.
#[derive(Debug, thiserror::Error)]
pub enum OutputError {
    /// The directory cannot be made or written to.
    #[error("cannot write to directory '{}': {source}; choose another with {option} DIR", path.display())]
    Directory {
        /// The directory.
        path: PathBuf,
        /// The option that chooses the directory.
        option: &'static str,
        /// What the system said.
        source: std::io::Error,
    },
    /// A file to be written is one that was read.
    #[error("'{}' is read here and would be overwritten; choose another place with {option}", path.display())]
    WouldOverwriteInput {
        /// The file.
        path: PathBuf,
        /// The option that chooses the place.
        option: &'static str,
    },
    /// A file cannot be written.
    #[error("cannot write '{}': {source}; choose another path with {option}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// The option that chooses the path.
        option: &'static str,
        /// What the system said.
        source: std::io::Error,
    },
}

/// The option that most results are sent by.
pub const OUT: &str = "--out";

/// A directory that exists and takes files.
#[derive(Clone, Debug)]
pub struct OutputDir(PathBuf);

impl OutputDir {
    /// Makes the directory if need be, and tries whether it takes a file, so that a long run does not find out at its
    /// end.
    ///
    /// # Errors
    /// [`OutputError::Directory`] when it does not.
    pub fn prepare(path: &Path) -> Result<Self, OutputError> {
        Self::prepare_for(path, OUT)
    }

    /// The same for a directory that was chosen by another option.
    ///
    /// # Errors
    /// [`OutputError::Directory`] when it does not.
    pub fn prepare_for(path: &Path, option: &'static str) -> Result<Self, OutputError> {
        let failed = |source| OutputError::Directory { path: path.to_owned(), option, source };
        fs::create_dir_all(path).map_err(failed)?;
        new_in(path).map_err(failed)?;
        Ok(OutputDir(path.to_owned()))
    }

    /// Refuses to go on when a file of this directory named in `names` is the `input`.
    ///
    /// # Errors
    /// [`OutputError::WouldOverwriteInput`] when it is.
    pub fn spares(&self, input: &Path, names: &[&str]) -> Result<(), OutputError> {
        names.iter().try_for_each(|name| spares(input, &self.0.join(name), OUT))
    }

    /// Begins a file.
    ///
    /// # Errors
    /// [`OutputError::File`] when the system refuses.
    pub fn create(&self, name: &str) -> Result<PendingFile, OutputError> {
        PendingFile::create(&self.0.join(name), OUT)
    }

    /// Writes a whole file and returns where it is.
    ///
    /// # Errors
    /// [`OutputError::File`] when the system refuses.
    pub fn write(&self, name: &str, text: &str) -> Result<PathBuf, OutputError> {
        self.create(name)?.finish_with(text)
    }
}

/// Refuses when `output`, chosen by an option, is the same file as `input`.
///
/// # Errors
/// [`OutputError::WouldOverwriteInput`] when it is.
pub fn spares(input: &Path, output: &Path, option: &'static str) -> Result<(), OutputError> {
    // A file that is not there yet has no canonical path, and nothing to lose.
    match (input.canonicalize(), output.canonicalize()) {
        (Ok(input_path), Ok(output_path)) if input_path == output_path => {
            Err(OutputError::WouldOverwriteInput { path: input.to_owned(), option })
        }
        _ => Ok(()),
    }
}

/// A file of a name that nobody has, which goes with its path; not by tempfile's own way, which says that name in every error.
fn new_in(directory: &Path) -> std::io::Result<(File, TempPath)> {
    tempfile::Builder::new().make_in(directory, |path| File::create_new(path)).map(tempfile::NamedTempFile::into_parts)
}

/// A file that appears under its name only when it is finished. What is no file, such as a pipe, is written to as it is.
#[derive(Debug)]
pub struct PendingFile {
    path: PathBuf,
    option: &'static str,
    writer: BufWriter<File>,
    /// Where it is written first.
    beside: Option<TempPath>,
}

impl PendingFile {
    /// Begins a file at `path`, which was chosen by an option.
    ///
    /// # Errors
    /// [`OutputError::File`] when the system refuses.
    pub fn create(path: &Path, option: &'static str) -> Result<Self, OutputError> {
        let failed = |source| OutputError::File { path: path.to_owned(), option, source };
        let (file, beside) = match fs::metadata(path) {
            Ok(there) if there.is_dir() => return Err(failed(std::io::ErrorKind::IsADirectory.into())),
            Ok(there) if !there.is_file() => (File::options().write(true).open(path).map_err(failed)?, None),
            _ => {
                let directory = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
                let (file, beside) = new_in(directory).map_err(failed)?;
                (file, Some(beside))
            }
        };
        Ok(PendingFile { path: path.to_owned(), option, writer: BufWriter::with_capacity(1 << 16, file), beside })
    }

    /// The error for something that went wrong while writing this file.
    #[must_use]
    pub fn failed(&self, source: std::io::Error) -> OutputError {
        OutputError::File { path: self.path.clone(), option: self.option, source }
    }

    /// Writes a text, moves the file into its place and returns it.
    ///
    /// # Errors
    /// [`OutputError::File`] when the system refuses.
    pub fn finish_with(mut self, text: &str) -> Result<PathBuf, OutputError> {
        self.write_all(text.as_bytes()).map_err(|source| self.failed(source))?;
        self.finish()
    }

    /// Moves the file into its place and returns it.
    ///
    /// # Errors
    /// [`OutputError::File`] when the system refuses.
    pub fn finish(self) -> Result<PathBuf, OutputError> {
        let PendingFile { path, option, writer, beside } = self;
        let failed = |source| OutputError::File { path: path.clone(), option, source };
        // Closed before it is moved: not every system moves what is open.
        drop(writer.into_inner().map_err(|e| failed(e.into_error()))?);
        beside.map_or(Ok(()), |beside| beside.persist(&path)).map_err(|e| failed(e.error))?;
        Ok(path)
    }
}

impl Write for PendingFile {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.writer.write(bytes)
    }

    fn flush(&mut self) -> std::io::Result<()> {
        self.writer.flush()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_that_is_dropped_before_it_is_finished_leaves_nothing_behind() {
        let dir = tempfile::tempdir().unwrap();
        let out = OutputDir::prepare(&dir.path().join("a/b")).unwrap();
        let mut pending = out.create("half.csv").unwrap();
        pending.write_all(b"1,2,3").unwrap();
        drop(pending);
        assert_eq!(fs::read_dir(dir.path().join("a/b")).unwrap().count(), 0);
        let path = out.write("whole.csv", "1,2\n").unwrap();
        assert_eq!(fs::read_to_string(path).unwrap(), "1,2\n");
    }

    #[test]
    fn a_directory_that_is_a_file_is_refused_with_its_name_and_the_remedy() {
        let file = tempfile::NamedTempFile::new().unwrap();
        let message = OutputDir::prepare(file.path()).unwrap_err().to_string();
        assert!(message.contains("--out DIR") && message.contains(file.path().to_str().unwrap()), "{message}");
    }
}

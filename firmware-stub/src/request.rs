//! What can be asked for while the monitor runs: one byte each over a serial line, and the set point with its value.

use monitor_core::units::RadPerSec;

/// Something asked of the main loop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Request {
    /// `c`: what of the last verdict is due to each channel: its deviation in `guard` mode, its contribution to T2 in `paper` mode.
    ByChannel,
    /// `s`: counts, and mean and sigma of each channel.
    Statistics,
    /// `v`: the last verdict, and what is wrong.
    Verdict,
    /// `a`: the motor is healthy as it runs now. Withdraws an alarm by which nothing is learned; of no meaning in `paper` mode.
    Acknowledge,
    /// `p` and four bytes, an `f32` in rad/s, little endian: the motor controller has a new set point.
    SetPoint(RadPerSec),
}

/// Puts requests together from the bytes of a serial line. Bytes that begin no request are passed over.
#[derive(Clone, Copy, Debug, Default)]
pub struct Requests {
    /// Bytes of a set point seen so far, the letter included; zero outside one.
    seen: u8,
    bits: u32,
}

impl Requests {
    /// Takes one byte; returns the request it completes.
    pub fn byte(&mut self, byte: u8) -> Option<Request> {
        if self.seen > 0 {
            return self.value(byte);
        }
        match byte {
            b'c' => Some(Request::ByChannel),
            b's' => Some(Request::Statistics),
            b'v' => Some(Request::Verdict),
            b'a' => Some(Request::Acknowledge),
            b'p' => {
                *self = Requests { seen: 1, bits: 0 };
                None
            }
            _ => None,
        }
    }

    /// A byte of a set point. The lowest comes first, so each new one pushes the others down.
    fn value(&mut self, byte: u8) -> Option<Request> {
        self.bits = self.bits >> 8 | u32::from(byte) << 24;
        self.seen += 1;
        if self.seen < 5 {
            return None;
        }
        self.seen = 0;
        Some(Request::SetPoint(RadPerSec(f32::from_bits(self.bits))))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn all(bytes: &[u8]) -> impl Iterator<Item = Request> {
        let mut requests = Requests::default();
        bytes.iter().filter_map(move |byte| requests.byte(*byte))
    }

    #[test]
    fn letters_are_requests_and_anything_else_is_passed_over() {
        let expected = [Request::ByChannel, Request::Verdict, Request::Statistics, Request::Acknowledge];
        assert!(all(b"\r\nc?v\0s\xffa").eq(expected));
    }

    #[test]
    fn a_set_point_is_the_number_sent_and_its_bytes_are_no_requests() {
        // 'c' 's' 'v' 'p' are bytes of this number.
        let number = f32::from_le_bytes(*b"csvp");
        let mut sent = [b'p', 0, 0, 0, 0, b'v'];
        sent[1..5].copy_from_slice(&number.to_le_bytes());
        assert!(all(&sent).eq([Request::SetPoint(RadPerSec(number)), Request::Verdict]));
    }
}

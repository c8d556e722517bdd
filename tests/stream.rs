//! Streams to the emulated board: header, records, and the check words between them.

use firmware_stub::record::{self, CHUNK, Header};

/// A stream that is being written.
#[derive(Clone, Debug)]
pub struct Stream {
    words: Vec<u32>,
    /// Where the chunk begins that is not checked yet, and how many records it holds.
    chunk: (usize, usize),
}

impl Stream {
    /// A stream with its header.
    #[must_use]
    pub fn new(header: &Header) -> Self {
        let mut words = header.to_words().to_vec();
        words.push(record::check_word(&words));
        let chunk = (words.len(), 0);
        Stream { words, chunk }
    }

    /// Appends a record.
    pub fn push(&mut self, record: &[u32]) {
        self.words.extend_from_slice(record);
        self.chunk.1 += 1;
        if self.chunk.1 == CHUNK {
            self.check();
        }
    }

    /// The whole stream.
    #[must_use]
    pub fn finish(mut self) -> Vec<u32> {
        if self.chunk.1 > 0 {
            self.check();
        }
        self.words
    }

    fn check(&mut self) {
        let check = record::check_word(self.words.get(self.chunk.0..).unwrap_or_default());
        self.words.push(check);
        self.chunk = (self.words.len(), 0);
    }
}

/// Words as they travel.
#[must_use]
pub fn bytes(words: &[u32]) -> Vec<u8> {
    words.iter().flat_map(|word| word.to_le_bytes()).collect()
}

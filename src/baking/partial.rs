//! The file from which an interrupted bake is resumed.
//!
//! A header, then one record for each batch of texels: length and hash of the body, and the body: rays (u64), seconds
//! (f64), and for each texel the number of intervals and two bytes for each. Numbers are little endian. A record that was
//! cut off by the interruption is dropped.

use std::fs::{File, OpenOptions};
use std::io::{ErrorKind, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use crate::techniques::occlusion_interval::intervals::{Interval, Intervals};
use crate::techniques::occlusion_interval::surface::StableHash;

/// First bytes of the file; the number is the version of its format.
const MAGIC: &[u8; 16] = b"antumbra bake 1\n";

/// Number of texels whose rays are cast, and saved, together.
pub(super) const BATCH: usize = if cfg!(test) { 64 } else { 4096 };

/// The result of one batch of texels.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Batch {
    /// Intervals of each texel.
    pub texels: Vec<Intervals>,
    /// Number of rays.
    pub rays: u64,
    /// Time that they took, seconds.
    pub seconds: f64,
}

/// An open file of batches.
#[derive(Debug)]
pub struct PartialFile {
    path: PathBuf,
    file: File,
}

impl PartialFile {
    /// Opens a file, and returns the batches that are whole. A file of another bake (another `key`), or with other content,
    /// is emptied. Waits while another bake, of any process, has the file open.
    ///
    /// # Errors
    /// Message of the operating system.
    pub fn open(path: &Path, key: u64) -> std::io::Result<(Self, Vec<Batch>)> {
        if let Some(folder) = path.parent() {
            std::fs::create_dir_all(folder)?;
        }
        let mut file = open_alone(path)?;
        let mut bytes = Vec::new();
        file.read_to_end(&mut bytes)?;
        let header = header(key);
        let mut batches = Vec::new();
        let mut whole = 0;
        if bytes.starts_with(&header) {
            whole = header.len();
            while let Some((batch, end)) = read_record(&bytes, whole) {
                batches.push(batch);
                whole = end;
            }
        }
        file.set_len(whole as u64)?;
        file.seek(SeekFrom::End(0))?;
        if whole == 0 {
            file.write_all(&header)?;
        }
        let path = path.to_owned();
        Ok((Self { path, file }, batches))
    }

    /// Appends a batch.
    ///
    /// # Errors
    /// Message of the operating system.
    pub fn append(&mut self, batch: &Batch) -> std::io::Result<()> {
        let body = body(batch);
        let mut record = Vec::with_capacity(body.len() + 12);
        record.extend((body.len() as u32).to_le_bytes());
        record.extend(hash(&body).to_le_bytes());
        record.extend(body);
        self.file.write_all(&record)?;
        self.file.flush()
    }

    /// Removes the file, once its bake is saved. It may be gone already.
    ///
    /// # Errors
    /// Message of the operating system.
    pub fn remove(self) -> std::io::Result<()> {
        match std::fs::remove_file(self.path) {
            Err(error) if error.kind() == ErrorKind::NotFound => Ok(()),
            other => other,
        }
    }

    /// Removes a file that was left beside finished maps, if it is the file of a bake.
    ///
    /// # Errors
    /// Message of the operating system.
    pub fn remove_left(path: &Path) -> std::io::Result<()> {
        let mut magic = [0; MAGIC.len()];
        match File::open(path).and_then(|mut file| file.read_exact(&mut magic)) {
            Ok(()) if magic == *MAGIC => std::fs::remove_file(path),
            _ => Ok(()),
        }
    }
}

/// Opens a file that no other bake has open, after waiting for those. It is made if it is missing.
fn open_alone(path: &Path) -> std::io::Result<File> {
    let mut options = OpenOptions::new();
    options.read(true).write(true).create(true).truncate(false);
    loop {
        let file = options.open(path)?;
        match file.lock() {
            // Not every file system knows locks.
            Err(error) if error.kind() == ErrorKind::Unsupported => return Ok(file),
            other => other?,
        }
        // The bake that had it may have ended and removed it.
        if path.exists() {
            return Ok(file);
        }
    }
}

fn header(key: u64) -> Vec<u8> {
    [&MAGIC[..], &key.to_le_bytes()].concat()
}

fn hash(body: &[u8]) -> u64 {
    let mut hash = StableHash::default();
    hash.add_bytes(body);
    hash.value()
}

fn body(batch: &Batch) -> Vec<u8> {
    let mut body = Vec::new();
    body.extend(batch.rays.to_le_bytes());
    body.extend(batch.seconds.to_le_bytes());
    for intervals in &batch.texels {
        body.push(intervals.len() as u8);
        body.extend(
            intervals
                .iter()
                .flat_map(|interval| [interval.rise, interval.fall]),
        );
    }
    body
}

fn eight(bytes: &[u8]) -> Option<[u8; 8]> {
    bytes.get(..8)?.try_into().ok()
}

/// Reads the record at an offset, and returns where the next one begins. `None` if it is not whole.
fn read_record(bytes: &[u8], at: usize) -> Option<(Batch, usize)> {
    let (length, rest) = bytes.get(at..)?.split_first_chunk::<4>()?;
    let length = u32::from_le_bytes(*length) as usize;
    let (expected, rest) = rest.split_first_chunk::<8>()?;
    let expected = u64::from_le_bytes(*expected);
    let body = rest.get(..length)?;
    if hash(body) != expected {
        return None;
    }
    let mut batch = Batch {
        texels: Vec::new(),
        rays: u64::from_le_bytes(eight(body)?),
        seconds: f64::from_le_bytes(eight(body.get(8..)?)?),
    };
    let mut rest = body.get(16..)?;
    while let Some((&count, after)) = rest.split_first() {
        let bytes = after.get(..2 * usize::from(count))?;
        let interval = |edges: &[u8]| Interval {
            rise: edges[0],
            fall: edges[1],
        };
        batch.texels.push(bytes.chunks_exact(2).map(interval).collect());
        rest = &after[bytes.len()..];
    }
    Some((batch, at + 12 + length))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::techniques::occlusion_interval::intervals::intervals_of;

    fn batch(seed: usize) -> Batch {
        Batch {
            texels: (0..7)
                .map(|i| intervals_of(|step| (step / (i + seed + 1)).is_multiple_of(2)))
                .collect(),
            rays: 100 + seed as u64,
            seconds: 0.25 * seed as f64,
        }
    }

    fn scratch(name: &str) -> PathBuf {
        std::env::temp_dir().join(format!("antumbra-{}-{name}", std::process::id()))
    }

    #[test]
    fn batches_are_read_back_and_a_cut_one_is_dropped() {
        let path = scratch("partial");
        let (mut file, known) = PartialFile::open(&path, 7).expect("a new file");
        assert!(known.is_empty());
        for seed in 0..3 {
            file.append(&batch(seed)).expect("it is written");
        }
        drop(file);
        let (_, known) = PartialFile::open(&path, 7).expect("the file");
        assert_eq!(known, [batch(0), batch(1), batch(2)]);
        let length = std::fs::metadata(&path).expect("the file").len();
        let cut = OpenOptions::new().write(true).open(&path).expect("the file");
        cut.set_len(length - 1).expect("it is cut");
        let (mut file, known) = PartialFile::open(&path, 7).expect("the file");
        assert_eq!(known.len(), 2);
        file.append(&batch(5)).expect("it is written");
        drop(file);
        let (file, known) = PartialFile::open(&path, 7).expect("the file");
        assert_eq!(known, [batch(0), batch(1), batch(5)]);
        file.remove().expect("it is removed");
        assert!(!path.exists());
    }

    /// A second bake of a folder waits until the first one has ended, and finds a new file.
    #[test]
    fn two_bakes_of_one_folder_take_turns() {
        let path = scratch("turns");
        let (mut first, _) = PartialFile::open(&path, 7).expect("a new file");
        std::thread::scope(|threads| {
            let second = threads.spawn(|| PartialFile::open(&path, 7));
            std::thread::sleep(std::time::Duration::from_millis(50));
            assert!(!second.is_finished(), "it waits");
            first.append(&batch(0)).expect("it is written");
            first.remove().expect("it is removed");
            let (second, known) = second.join().expect("no panic").expect("a new file");
            assert!(known.is_empty() && path.exists());
            std::fs::remove_file(&path).expect("the file");
            second.remove().expect("it is gone already");
        });
    }

    #[test]
    fn another_bake_and_foreign_bytes_begin_anew() {
        let path = scratch("foreign");
        let (mut file, _) = PartialFile::open(&path, 7).expect("a new file");
        file.append(&batch(0)).expect("it is written");
        drop(file);
        let (_, known) = PartialFile::open(&path, 8).expect("the file");
        assert!(known.is_empty(), "of another bake");
        std::fs::write(&path, b"something else entirely").expect("it is written");
        let (file, known) = PartialFile::open(&path, 8).expect("the file");
        assert!(known.is_empty());
        drop(file);
        let (file, known) = PartialFile::open(&path, 8).expect("it was begun anew");
        assert!(known.is_empty());
        file.remove().expect("it is removed");
    }
}

//! A configuration to the board and back: in blocks, read back before it is committed, verified
//! after.
//!
//! Broken off anywhere, the old configuration stays: the board takes a new one only at the commit,
//! and only if length and checksum fit what has arrived. A repeated upload begins from the first
//! block.

use wire::Configuration;
use wire::registers::{
    Id, UPLOAD_REGISTERS, UploadOrder, UploadResult, Value, bytes_of, checksum, pack_bytes,
};

use super::Board;
use super::error::BoardError;

/// Bytes of a block.
const BLOCK: usize = 2 * UPLOAD_REGISTERS as usize;
/// A commit takes so many times the usual limit: the board validates, and erases flash.
const COMMIT_PATIENCE: u32 = 20;

/// The configuration as the board takes it.
///
/// # Errors
/// It does not fit.
fn encode(configuration: &Configuration, capacity: usize) -> Result<Vec<u8>, BoardError> {
    let mut buffer = vec![0; capacity];
    let too_large = |_| {
        let bytes = postcard::experimental::serialized_size(configuration).unwrap_or(usize::MAX);
        BoardError::TooLarge { bytes, capacity }
    };
    Ok(postcard::to_slice(configuration, &mut buffer).map_err(too_large)?.to_vec())
}

/// Uploads, reads back, commits and verifies. `moved` is told how many bytes of how many are done,
/// of both ways.
///
/// # Errors
/// Versions differ, the board refuses or does not answer. The old configuration is still installed,
/// but for [`BoardError::NotInstalled`].
pub fn deploy(
    board: &mut Board,
    configuration: &Configuration,
    moved: &dyn Fn(usize, usize),
) -> Result<usize, BoardError> {
    let bytes = stage(board, configuration, moved)?;
    commit(board, &bytes)?;
    Ok(bytes.len())
}

/// Uploads and reads back; answers the bytes that stand in the board's buffer, and do nothing yet.
/// `moved` is told how many bytes of how many are done, of both ways.
///
/// # Errors
/// Versions differ, the board refuses or does not answer.
pub fn stage(
    board: &mut Board,
    configuration: &Configuration,
    moved: &dyn Fn(usize, usize),
) -> Result<Vec<u8>, BoardError> {
    let version = board.identity().wire_version;
    if version != wire::VERSION {
        return Err(BoardError::WireVersion { board: version });
    }
    let capacity = board.read(Id::UploadCapacity, Id::UploadCapacity)?.whole(Id::UploadCapacity);
    let bytes = encode(configuration, capacity as usize)?;
    let all = 2 * bytes.len();
    for (block, content) in bytes.chunks(BLOCK).enumerate() {
        let words: Vec<u16> = std::iter::once((block * BLOCK) as u16).chain(pack_bytes(content)).collect();
        board.write(Id::UploadOffset, &words)?;
        moved(block * BLOCK, all);
    }
    let arrived = download(board, bytes.len(), &|done| moved(bytes.len() + done, all))?;
    if arrived == bytes { Ok(bytes) } else { Err(BoardError::ReadBack) }
}

/// Commits what was staged, and verifies.
///
/// # Errors
/// The board refuses or does not answer. The old configuration is still installed, but for
/// [`BoardError::NotInstalled`].
pub fn commit(board: &mut Board, bytes: &[u8]) -> Result<(), BoardError> {
    let sum = Value::U32(checksum(bytes));
    let head: Vec<u16> = std::iter::once(bytes.len() as u16).chain(sum.words()).collect();
    board.write(Id::UploadLength, &head)?;
    order_commit(board)?;
    if fetch_bytes(board)? == bytes { Ok(()) } else { Err(BoardError::NotInstalled) }
}

/// What is installed.
///
/// # Errors
/// No answer, or nothing that is a configuration of this version.
pub fn fetch(board: &mut Board) -> Result<Configuration, BoardError> {
    let bytes = fetch_bytes(board)?;
    postcard::from_bytes(&bytes).map_err(|_| BoardError::NoConfiguration)
}

fn order_commit(board: &mut Board) -> Result<(), BoardError> {
    let order = [UploadOrder::Commit.number()];
    match board.write_once(Id::UploadOrder, &order, COMMIT_PATIENCE) {
        // Whether it was heard is seen by what is installed.
        Err(error) if error.is_lost() => Ok(()),
        Err(error) if error.exception().is_some() => {
            let number = board.read(Id::UploadResult, Id::UploadResult)?.whole(Id::UploadResult);
            let result = UploadResult::of_number(number as u16).unwrap_or(UploadResult::None);
            if result == UploadResult::NotStored {
                return Err(BoardError::NotStored);
            }
            Err(BoardError::Refused { result, message: message(board)? })
        }
        done => Ok(done?),
    }
}

/// Why the board has refused, in its words.
pub(super) fn message(board: &mut Board) -> Result<String, BoardError> {
    let block = board.read(Id::Message, Id::Message)?;
    let bytes: Vec<u8> = bytes_of(block.words(Id::Message)).take_while(|&byte| byte != 0).collect();
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}

fn fetch_bytes(board: &mut Board) -> Result<Vec<u8>, BoardError> {
    match board.write(Id::UploadOrder, &[UploadOrder::Fetch.number()]) {
        Err(error) if error.exception().is_some() => return Err(BoardError::NoConfiguration),
        done => done?,
    }
    let head = board.read(Id::UploadLength, Id::UploadChecksum)?;
    let bytes = download(board, head.whole(Id::UploadLength) as usize, &|_| ())?;
    if checksum(&bytes) != head.whole(Id::UploadChecksum) { Err(BoardError::ReadBack) } else { Ok(bytes) }
}

/// The first bytes of the board's buffer.
fn download(board: &mut Board, length: usize, moved: &dyn Fn(usize)) -> Result<Vec<u8>, BoardError> {
    let mut bytes = Vec::with_capacity(length);
    while bytes.len() < length {
        board.set(Id::UploadOffset, bytes.len() as f64)?;
        let block = board.read(Id::UploadWindow, Id::UploadWindow)?;
        bytes.extend(bytes_of(block.words(Id::UploadWindow)).take(length - bytes.len()));
        moved(bytes.len());
    }
    Ok(bytes)
}

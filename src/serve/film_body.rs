//! The bytes of a film on their way to a client, piece by piece.

use std::io::{self, ErrorKind, SeekFrom};

use http_body_util::channel::{Channel, Sender};
use hyper::body::Bytes;
use tokio::fs::File;
use tokio::io::{AsyncReadExt, AsyncSeekExt};

use super::film::{OpenFilm, State};

/// Bytes that are read at once. A connection holds a few pieces at most, however slowly its client reads.
const PIECE_BYTES: u64 = 64 << 10;

/// Sends `length` bytes from `first` on. Where the file ends before, or has changed meanwhile, the body ends with an error, and with it
/// the connection, before its last byte is sent.
pub fn send(film: OpenFilm, first: u64, length: u64) -> Channel<Bytes, io::Error> {
    let (mut sender, body) = Channel::new(1);
    tokio::spawn(async move {
        if let Err(error) = send_pieces(film, first, length, &mut sender).await {
            sender.abort(error);
        }
    });
    body
}

async fn send_pieces(film: OpenFilm, first: u64, length: u64, sender: &mut Sender<Bytes, io::Error>) -> io::Result<()> {
    let state = film.state;
    let mut file = File::from_std(film.file);
    file.seek(SeekFrom::Start(first)).await?;
    let mut left = length;
    while left > 0 {
        let mut piece = vec![0; left.min(PIECE_BYTES) as usize];
        let read = file.read(&mut piece).await?;
        piece.truncate(read);
        left -= read as u64;
        let is_changed = left == 0 && State::of(&file.metadata().await?) != state;
        if read == 0 || is_changed {
            return Err(io::Error::new(ErrorKind::UnexpectedEof, "the file changed while it was sent"));
        }
        if sender.send_data(piece.into()).await.is_err() {
            // The client has gone.
            return Ok(());
        }
    }
    Ok(())
}

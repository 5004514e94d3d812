//! Sends the bytes of a film to a client, piece by piece.

use std::io::{self, ErrorKind};
use std::sync::Arc;

use http_body_util::channel::{Channel, Sender};
use hyper::body::Bytes;

use super::film::{OpenFilm, State};
use codec::container::ByteSource;

/// Bytes that are read at once. A connection holds at most a few pieces, however slowly its client reads.
const PIECE_BYTES: u64 = 64 << 10;

/// Sends `length` bytes starting at `first`. If the file ends early or has changed meanwhile, the body fails before its last
/// byte is sent, which closes the connection.
pub fn send(film: Arc<OpenFilm>, first: u64, length: u64) -> Channel<Bytes, io::Error> {
    let (mut sender, body) = Channel::new(1);
    tokio::spawn(async move {
        if let Err(error) = send_pieces(&film, first, length, &mut sender).await {
            sender.abort(error);
        }
    });
    body
}

async fn send_pieces(
    film: &Arc<OpenFilm>,
    first: u64,
    length: u64,
    sender: &mut Sender<Bytes, io::Error>,
) -> io::Result<()> {
    let (mut at, end) = (first, first + length);
    while at < end {
        let piece = (end - at).min(PIECE_BYTES);
        let is_last = at + piece == end;
        let film = Arc::clone(film);
        let read = tokio::task::spawn_blocking(move || film.read(at, piece, is_last));
        let bytes = read.await.map_err(io::Error::other)??;
        at += piece;
        if sender.send_data(bytes.into()).await.is_err() {
            // The client has disconnected.
            return Ok(());
        }
    }
    Ok(())
}

impl OpenFilm {
    /// Reads a piece. Fails if the file ends early or, for the last piece, if the file has changed meanwhile.
    fn read(&self, at: u64, count: u64, is_last: bool) -> io::Result<Vec<u8>> {
        let mut bytes = vec![0; count as usize];
        self.file.read_at(at, &mut bytes)?;
        if is_last && State::of(&self.file.metadata()?) != self.state {
            return Err(io::Error::new(ErrorKind::UnexpectedEof, "the file changed while it was sent"));
        }
        Ok(bytes)
    }
}

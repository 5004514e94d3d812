//! Responses to requests: status, headers and body.

use std::io;
use std::net::IpAddr;
use std::sync::{Arc, Mutex, PoisonError, Weak};
use std::time::Duration;

use http_body_util::channel::Channel;
use http_body_util::{Either, Full};
use hyper::body::Bytes;
use hyper::header::{
    ACCEPT_RANGES, ALLOW, CACHE_CONTROL, CONTENT_LENGTH, CONTENT_RANGE, CONTENT_SECURITY_POLICY, CONTENT_TYPE, ETAG,
    HeaderName, HeaderValue, RANGE, REFERRER_POLICY, X_CONTENT_TYPE_OPTIONS,
};
use hyper::http::request::Parts;
use hyper::{HeaderMap, Method, Response, StatusCode};

use super::conditions::{Verdict, allows_part, verdict};
use super::connections::Connections;
use super::film::{Film, OpenFilm};
use super::film_body;
use super::hosts::{Addressee, addressee};
use super::opening::{Opening, POSTER, POSTER_MEDIA_TYPE};
use super::player::PlayerFile;
use super::range::{Asked, asked};
use super::site::DESCRIPTION;
use codec::error::{Error, Result};
use footage::json;

pub type Body = Either<Full<Bytes>, Channel<Bytes, io::Error>>;

/// The page may load files of this server, WebAssembly among them, and images that it creates; nothing from other origins. No
/// page may frame it.
const CONTENT_POLICY: &str = "default-src 'none'; script-src 'self' 'wasm-unsafe-eval'; worker-src 'self'; \
    style-src 'self'; img-src 'self' blob: data:; connect-src 'self' blob:; base-uri 'none'; form-action 'none'; \
    frame-ancestors 'none'";
/// Features with a permission that the page may use: gamepads and headsets.
const PERMISSIONS: &str =
    "gamepad=(self), xr-spatial-tracking=(self), camera=(), display-capture=(), geolocation=(), microphone=(), usb=()";

/// Headers of every response.
const COMMON: [(HeaderName, &str); 8] = [
    (ACCEPT_RANGES, "bytes"),
    (CACHE_CONTROL, "no-cache"),
    (CONTENT_SECURITY_POLICY, CONTENT_POLICY),
    (X_CONTENT_TYPE_OPTIONS, "nosniff"),
    (REFERRER_POLICY, "no-referrer"),
    (HeaderName::from_static("cross-origin-opener-policy"), "same-origin"),
    (HeaderName::from_static("cross-origin-resource-policy"), "same-origin"),
    (HeaderName::from_static("permissions-policy"), PERMISSIONS),
];

/// Maximum retries of opening a film when the system is out of file descriptors, and the delay between them.
const OPEN_RETRIES: u32 = 20;
const OPEN_RETRY_DELAY: Duration = Duration::from_millis(5);

/// The served film and the address of the server.
#[derive(Debug)]
pub struct Served {
    film: Film,
    bound: IpAddr,
    connections: Arc<Connections>,
    /// The open film, if any response is sending it: connections share one open file.
    sent: Mutex<Weak<OpenFilm>>,
    /// The start of the film, with the tag of the file that it was read from.
    opening: Mutex<Option<(String, Arc<Opening>)>>,
}

impl Served {
    pub fn new(film: Film, bound: IpAddr, connections: Arc<Connections>) -> Served {
        Served { film, bound, connections, sent: Mutex::default(), opening: Mutex::default() }
    }

    /// Opens the file that currently has the film's name, or reuses it if it is open.
    fn open_film(&self) -> Result<Arc<OpenFilm>> {
        let now = self.film.open_now()?;
        let mut sent = self.sent.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(same) = sent.upgrade().filter(|sent| sent.tag() == now.tag()) {
            return Ok(same);
        }
        let now = Arc::new(now);
        *sent = Arc::downgrade(&now);
        Ok(now)
    }

    /// Returns the start of the film with this tag.
    fn opening(&self, tag: String) -> Arc<Opening> {
        let mut known = self.opening.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, opening)) = known.as_ref().filter(|(other, _)| *other == tag) {
            return Arc::clone(opening);
        }
        let opening = Arc::new(self.film.opening());
        *known = Some((tag, Arc::clone(&opening)));
        opening
    }

    /// Renders the poster, so that the first request does not wait for it. Blocks.
    pub fn prepare(&self) {
        if let Ok(film) = self.open_film() {
            self.opening(film.tag()).poster();
        }
    }
}

/// Opens the film on a blocking thread. If the system is out of file descriptors, closes connections and retries.
async fn open_film(served: &Arc<Served>) -> Result<Arc<OpenFilm>> {
    let mut tries = 0;
    loop {
        let opener = Arc::clone(served);
        let opened = tokio::task::spawn_blocking(move || opener.open_film()).await;
        let opened = opened.unwrap_or_else(|error| Err(Error::invalid(error.to_string())));
        match opened {
            Err(Error::Io { source, .. }) if is_out_of_files(&source) && tries < OPEN_RETRIES => {
                tries += 1;
                served.connections.out_of_files();
                tokio::time::sleep(OPEN_RETRY_DELAY).await;
            }
            opened => return opened,
        }
    }
}

/// True for `ENFILE` and `EMFILE`, or `ERROR_TOO_MANY_OPEN_FILES`.
pub fn is_out_of_files(error: &io::Error) -> bool {
    let codes: &[i32] = if cfg!(windows) { &[4] } else { &[23, 24] };
    error.raw_os_error().is_some_and(|code| codes.contains(&code))
}

/// A representation: its content and metadata.
struct Found {
    content: Content,
    length: u64,
    tag: String,
    media_type: &'static str,
}

enum Content {
    Bytes(Bytes),
    Film(Arc<OpenFilm>),
}

/// Responds to a request by its head; request bodies are not read.
pub async fn answer(served: &Arc<Served>, head: &Parts) -> Response<Body> {
    let refused = match addressee(head, served.bound) {
        Addressee::Unclear => Some((StatusCode::BAD_REQUEST, "one header Host was expected")),
        Addressee::Another => {
            Some((StatusCode::MISDIRECTED_REQUEST, "this server answers to its address and to localhost"))
        }
        Addressee::Ours if head.method != Method::GET && head.method != Method::HEAD => {
            Some((StatusCode::METHOD_NOT_ALLOWED, "GET or HEAD was expected"))
        }
        Addressee::Ours => None,
    };
    let mut response = match refused {
        Some((status, words)) => sentence(status, words),
        None => match find(served, head.uri.path()).await {
            Ok(Some(found)) => found.answer(head),
            Ok(None) => sentence(StatusCode::NOT_FOUND, "there is no such file"),
            Err(Error::Io { source, .. }) if source.kind() == io::ErrorKind::NotFound => {
                sentence(StatusCode::NOT_FOUND, "the film no longer exists")
            }
            Err(_) => sentence(StatusCode::INTERNAL_SERVER_ERROR, "the film cannot be read"),
        },
    };
    let headers = response.headers_mut();
    for (name, value) in COMMON {
        headers.insert(name, HeaderValue::from_static(value));
    }
    if refused.is_some_and(|(status, _)| status == StatusCode::METHOD_NOT_ALLOWED) {
        headers.insert(ALLOW, HeaderValue::from_static("GET, HEAD"));
    }
    response
}

/// Finds the representation of a path. The path is compared as is; nothing is decoded.
async fn find(served: &Arc<Served>, path: &str) -> Result<Option<Found>> {
    let Some(name) = path.strip_prefix('/') else { return Ok(None) };
    if let Some(file) = PlayerFile::named(name) {
        return Ok(Some(Found::of_bytes(Bytes::from_static(file.bytes), file.media_type())));
    }
    let is_film = name == served.film.url();
    if !is_film && ![DESCRIPTION, POSTER].contains(&name) {
        return Ok(None);
    }
    let film = open_film(served).await?;
    let (bytes, tag) = (film.state.bytes, film.tag());
    if !is_film {
        let (server, is_poster) = (Arc::clone(served), name == POSTER);
        let found = tokio::task::spawn_blocking(move || {
            let opening = server.opening(tag);
            if is_poster {
                let poster = opening.poster().map(<[u8]>::to_vec);
                return Ok(poster.map(|jpeg| Found::of_bytes(jpeg.into(), POSTER_MEDIA_TYPE)));
            }
            let text = json::pretty(&server.film.description(bytes, &opening))?;
            Ok(Some(Found::of_bytes(text.into(), "application/json")))
        });
        return found.await.unwrap_or_else(|error| Err(Error::invalid(error.to_string())));
    }
    let media_type = served.film.media_type();
    Ok(Some(Found { content: Content::Film(film), length: bytes, tag, media_type }))
}

impl Found {
    fn of_bytes(bytes: Bytes, media_type: &'static str) -> Found {
        let tag = format!("\"{:x}-{:08x}\"", bytes.len(), crc32fast::hash(&bytes));
        Found { length: bytes.len() as u64, tag, media_type, content: Content::Bytes(bytes) }
    }

    fn answer(self, head: &Parts) -> Response<Body> {
        let (headers, length) = (&head.headers, self.length);
        let tag = self.tag.clone();
        let mut response = match verdict(headers, &tag) {
            Verdict::NotModified => empty(StatusCode::NOT_MODIFIED),
            Verdict::Failed => sentence(StatusCode::PRECONDITION_FAILED, "the file has changed"),
            Verdict::Send => match asked_of(head, &tag, length) {
                Asked::Unsatisfiable => {
                    let mut response = sentence(StatusCode::RANGE_NOT_SATISFIABLE, "the range lies beyond the end");
                    insert(response.headers_mut(), CONTENT_RANGE, format!("bytes */{length}"));
                    response
                }
                Asked::Whole => self.part(head, StatusCode::OK, 0, length),
                Asked::Part { first, length: part } => {
                    let mut response = self.part(head, StatusCode::PARTIAL_CONTENT, first, part);
                    let range = format!("bytes {first}-{}/{length}", first + part - 1);
                    insert(response.headers_mut(), CONTENT_RANGE, range);
                    response
                }
            },
        };
        insert(response.headers_mut(), ETAG, tag);
        response
    }

    /// Sends `length` bytes starting at `first`; the range must be within the representation.
    fn part(self, head: &Parts, status: StatusCode, first: u64, length: u64) -> Response<Body> {
        let mut response = empty(status);
        if head.method != Method::HEAD {
            *response.body_mut() = match self.content {
                // Content in memory: its length is a usize.
                Content::Bytes(bytes) => {
                    Either::Left(Full::new(bytes.slice(first as usize..(first + length) as usize)))
                }
                Content::Film(film) => Either::Right(film_body::send(film, first, length)),
            };
        }
        let headers = response.headers_mut();
        headers.insert(CONTENT_TYPE, HeaderValue::from_static(self.media_type));
        headers.insert(CONTENT_LENGTH, HeaderValue::from(length));
        response
    }
}

/// Returns the part of a representation to send. A range only applies to GET, if there is exactly one, and if `If-Range` allows
/// it.
fn asked_of(head: &Parts, tag: &str, length: u64) -> Asked {
    let mut ranges = head.headers.get_all(RANGE).iter();
    match (ranges.next().and_then(|value| value.to_str().ok()), ranges.next()) {
        (Some(range), None) if head.method == Method::GET && allows_part(&head.headers, tag) => asked(range, length),
        _ => Asked::Whole,
    }
}

fn empty(status: StatusCode) -> Response<Body> {
    let mut response = Response::new(Either::Left(Full::default()));
    *response.status_mut() = status;
    response
}

/// Returns a text response for people. The HTTP library drops the body for HEAD.
fn sentence(status: StatusCode, words: &str) -> Response<Body> {
    let mut response = empty(status);
    *response.body_mut() = Either::Left(Full::from(format!("{status}: {words}\n")));
    response.headers_mut().insert(CONTENT_TYPE, HeaderValue::from_static("text/plain; charset=utf-8"));
    response
}

/// Sets a header; the value must consist of printable characters.
fn insert(headers: &mut HeaderMap, name: HeaderName, value: String) {
    if let Ok(value) = HeaderValue::try_from(value) {
        headers.insert(name, value);
    }
}

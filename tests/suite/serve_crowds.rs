//! `lightfold view` with many clients that are idle, slow, or do not read what they requested.

use std::fs::File;
use std::io::{ErrorKind, Read, Write};
use std::net::{Ipv4Addr, SocketAddr, TcpStream};
use std::path::Path;
use std::process::Command;
use std::time::Duration;

use cli::serve::{self, Film, Limits, Stop};
use tempfile::TempDir;

use crate::serve::{LARGE, PATIENCE, Server, write_glb};

const GET_FILM: &[u8] = b"GET /film.glb HTTP/1.1\r\nHost: localhost\r\n\r\n";

/// A client that keeps its connection open without progress.
#[derive(Debug, Clone, Copy)]
enum Client {
    Idle,
    /// Sends an incomplete request header.
    HalfHead,
    /// Requests the film and does not read the response.
    Greedy,
    /// Requests the film and reads one byte of the response.
    Slow,
    /// Sends many requests for the film without reading responses.
    Pipelined,
    /// Has received a response.
    Served,
}

const CLIENTS: [Client; 6] =
    [Client::Idle, Client::HalfHead, Client::Greedy, Client::Slow, Client::Pipelined, Client::Served];

impl Client {
    /// Starts the client. The server may close the connection meanwhile, so errors are ignored.
    fn begin(self, mut stream: TcpStream) -> TcpStream {
        let sent = match self {
            Client::Idle => Ok(()),
            Client::HalfHead => stream.write_all(b"GET /film.glb HTTP/1.1\r\nHost: loc"),
            Client::Greedy => stream.write_all(GET_FILM),
            Client::Slow => stream.write_all(GET_FILM).and_then(|()| stream.read(&mut [0]).map(drop)),
            Client::Pipelined => stream.write_all(&GET_FILM.repeat(100)),
            Client::Served => stream
                .write_all(b"HEAD /film.json HTTP/1.1\r\nHost: localhost\r\n\r\n")
                .and_then(|()| stream.read(&mut [0; 4096]).map(drop)),
        };
        drop(sent);
        stream
    }
}

fn large_film() -> TempDir {
    let folder = TempDir::new().unwrap();
    write_glb(&folder.path().join("large.glb"), LARGE);
    folder
}

/// Raises the limit of open files to what the tests need.
fn allow_open_files() {
    #[cfg(unix)]
    {
        use rustix::process::{Resource, getrlimit, setrlimit};
        let mut limit = getrlimit(Resource::Nofile);
        let most = limit.maximum.unwrap_or(u64::MAX);
        if limit.current.is_some_and(|now| now < 8192) {
            limit.current = Some(most.min(8192));
            setrlimit(Resource::Nofile, limit).unwrap();
        }
    }
}

fn check_requests(server: &Server, crowd: &str) {
    for _ in 0..3 {
        assert_eq!(server.get("/film.json").status, 200, "{crowd}");
        assert_eq!(server.get("/").status, 200, "{crowd}");
        let part = server.ask("GET", "/film.glb", "Range: bytes=-999999\r\n");
        assert_eq!((part.status, part.body.len()), (206, 999_999), "{crowd}");
    }
}

#[test]
fn crowds_do_not_hold_up_a_request() {
    allow_open_files();
    let folder = large_film();
    for client in CLIENTS {
        let server = Server::start(folder.path(), "large.glb");
        let crowd: Vec<TcpStream> = (0..1000).map(|_| client.begin(server.connect())).collect();
        check_requests(&server, &format!("{client:?}"));
        drop(crowd);
    }
    let server = Server::start(folder.path(), "large.glb");
    let mixed: Vec<TcpStream> =
        CLIENTS.iter().cycle().take(1000).map(|client| client.begin(server.connect())).collect();
    std::thread::scope(|scope| {
        for _ in 0..8 {
            scope.spawn(|| check_requests(&server, "a mixed crowd"));
        }
    });
    drop(mixed);
}

#[cfg(unix)]
#[test]
fn running_out_of_files_does_not_hold_up_a_request() {
    allow_open_files();
    let folder = large_film();
    let mut command = Command::new("sh");
    let program = env!("CARGO_BIN_EXE_lightfold");
    let line = format!("ulimit -n 64; exec '{program}' view large.glb -q");
    command.args(["-c", &line]).current_dir(folder.path());
    let server = Server::spawn(command);
    for client in CLIENTS {
        let crowd: Vec<TcpStream> = (0..200).map(|_| client.begin(server.connect())).collect();
        check_requests(&server, &format!("{client:?}"));
        drop(crowd);
    }
}

/// Serves a film through the library while `check` runs.
fn with_server(folder: &Path, limits: Limits, check: impl FnOnce(SocketAddr)) {
    let film = Film::open(&folder.join("large.glb")).unwrap();
    let server = serve::Server::bind(film, (Ipv4Addr::LOCALHOST, 0).into(), limits).unwrap();
    let (address, stop) = (server.address(), Stop::default());
    std::thread::scope(|scope| {
        scope.spawn(|| server.run(&stop));
        check(address);
        stop.stop();
    });
}

fn connect(address: SocketAddr) -> TcpStream {
    let stream = TcpStream::connect(address).unwrap();
    stream.set_read_timeout(Some(PATIENCE)).unwrap();
    stream
}

/// Reads until a connection ends; fails if it does not end.
fn wait_for_end(stream: &mut TcpStream) {
    match std::io::copy(stream, &mut std::io::sink()) {
        Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => panic!("open: {error}"),
        // The connection was closed or reset.
        _ => {}
    }
}

fn is_open(stream: &TcpStream) -> bool {
    stream.set_nonblocking(true).unwrap();
    matches!((&mut &*stream).read(&mut [0]), Err(error) if error.kind() == ErrorKind::WouldBlock)
}

#[test]
fn a_connection_without_progress_is_closed() {
    let folder = large_film();
    let limits = Limits { progress_timeout: Duration::from_millis(200), ..Limits::default() };
    with_server(folder.path(), limits, |address| {
        for client in CLIENTS {
            wait_for_end(&mut client.begin(connect(address)));
        }
        // A client that does not read receives less than the whole film before the connection is closed.
        let mut greedy = Client::Greedy.begin(connect(address));
        std::thread::sleep(limits.progress_timeout * 10);
        let mut film = Vec::new();
        let _ = greedy.read_to_end(&mut film);
        assert!(film.len() < LARGE as usize, "{}", film.len());
    });
}

#[test]
fn a_new_connection_takes_the_place_of_the_one_without_progress() {
    let folder = large_film();
    let limits = Limits { max_connections: 4, progress_timeout: PATIENCE * 10 };
    with_server(folder.path(), limits, |address| {
        let mut idle: Vec<TcpStream> = (0..3).map(|_| connect(address)).collect();
        let served = Client::Served.begin(connect(address));
        // The oldest connection receives a response, so it counts as having made progress.
        idle[0].write_all(b"HEAD / HTTP/1.1\r\nHost: localhost\r\n\r\n").unwrap();
        assert!(idle[0].read(&mut [0; 4096]).unwrap() > 100);
        let newest: Vec<TcpStream> = (0..2).map(|_| Client::Served.begin(connect(address))).collect();
        wait_for_end(&mut idle[1]);
        wait_for_end(&mut idle[2]);
        assert!(is_open(&idle[0]) && is_open(&served) && newest.iter().all(is_open));
    });
}

#[test]
fn a_film_is_opened_once_for_all_connections() {
    let folder = large_film();
    let file = File::open(folder.path().join("large.glb")).unwrap();
    with_server(folder.path(), Limits::default(), |address| {
        let crowd: Vec<TcpStream> = (0..20).map(|_| Client::Slow.begin(connect(address))).collect();
        #[cfg(target_os = "linux")]
        {
            let open = std::fs::read_dir("/proc/self/fd").unwrap();
            let film = folder.path().join("large.glb").canonicalize().unwrap();
            let names = open.filter_map(|entry| std::fs::read_link(entry.unwrap().path()).ok());
            assert!(
                names.filter(|name| *name == film).count() <= 4,
                "one of this test, one that is sent, one in passing"
            );
        }
        drop(crowd);
    });
    drop(file);
}

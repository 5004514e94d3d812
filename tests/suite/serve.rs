//! `lightfold view`: responses of its server, tested over sockets.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::{BufRead, BufReader, Read, Seek, SeekFrom, Write};
use std::net::TcpStream;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use codec::image::{Face, Plane};
use footage::image_files::png;
use serde_json::{Value, json};
use tempfile::TempDir;

use crate::commands::{fine, lightfold, refused};
use crate::footage::Footage;
use crate::schemas;

/// Timeout that no response approaches: a server that does not respond fails its test.
pub const PATIENCE: Duration = Duration::from_secs(100);

/// Creates a folder with a small container, `a.lfold`.
pub fn place() -> TempDir {
    let folder = TempDir::new().unwrap();
    let depth = |_: Face, frame: u32| Plane::from_fn(16, 16, |x, y| 1.0 + (x * y + frame) as f32 * 0.01);
    Footage { frames: [0, 1], depth: Some(&depth), ..Footage::new(16, 16) }.write(folder.path());
    fine("encode . -o a.lfold", folder.path());
    folder
}

/// Writes a file with a binary glTF header that states `bytes` as its length; the rest is zero.
pub fn write_glb(path: &Path, bytes: u32) {
    let mut file = File::create(path).unwrap();
    file.write_all(&[&b"glTF\x02\0\0\0"[..], &bytes.to_le_bytes()].concat()).unwrap();
    file.set_len(bytes.into()).unwrap();
    file.set_modified(UNIX_EPOCH).unwrap();
}

/// A running `lightfold view`, killed on drop.
pub struct Server {
    child: Child,
    port: u16,
}

impl Server {
    pub fn start(folder: &Path, words: &str) -> Server {
        let mut command = Command::new(env!("CARGO_BIN_EXE_lightfold"));
        command.arg("view").args(words.split(' ')).arg("-q").current_dir(folder);
        Server::spawn(command)
    }

    /// Starts a command that runs the server.
    pub fn spawn(mut command: Command) -> Server {
        let mut child = command.stdin(Stdio::null()).stdout(Stdio::piped()).spawn().unwrap();
        let mut line = String::new();
        BufReader::new(child.stdout.take().unwrap()).read_line(&mut line).unwrap();
        let port = line.strip_prefix("http://127.0.0.1:").and_then(|rest| rest.strip_suffix("/\n")?.parse().ok());
        Server { child, port: port.unwrap_or_else(|| panic!("{command:?}: no address in {line:?}")) }
    }

    pub fn connect(&self) -> TcpStream {
        let stream = TcpStream::connect(("127.0.0.1", self.port)).unwrap();
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        stream.set_write_timeout(Some(PATIENCE)).unwrap();
        stream
    }

    /// Sends a request header verbatim and reads until the connection is closed.
    fn raw(&self, head: &str) -> Answer {
        let mut stream = self.connect();
        stream.write_all(head.as_bytes()).unwrap();
        Answer::read(&mut BufReader::new(stream))
    }

    /// Sends one request with additional header fields, each terminated by `\r\n`.
    pub fn ask(&self, method: &str, path: &str, headers: &str) -> Answer {
        let host = self.port;
        self.raw(&format!("{method} {path} HTTP/1.1\r\nHost: 127.0.0.1:{host}\r\nConnection: close\r\n{headers}\r\n"))
    }

    pub fn get(&self, path: &str) -> Answer {
        self.ask("GET", path, "")
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

#[derive(Debug)]
pub struct Answer {
    pub status: u16,
    headers: BTreeMap<String, String>,
    pub body: Vec<u8>,
}

impl Answer {
    /// Reads the status line and the header fields; the body is not read.
    fn read_head(stream: &mut impl BufRead) -> Answer {
        let mut lines = Vec::new();
        loop {
            let mut line = String::new();
            assert!(stream.read_line(&mut line).unwrap() > 0, "the connection ended in the head: {lines:?}");
            match line.trim_end() {
                "" => break,
                line => lines.push(line.to_owned()),
            }
        }
        let status = lines[0].split(' ').nth(1).unwrap().parse().unwrap();
        let headers = lines[1..].iter().map(|line| line.split_once(": ").unwrap());
        let headers = headers.map(|(name, value)| (name.to_ascii_lowercase(), value.to_owned())).collect();
        Answer { status, headers, body: Vec::new() }
    }

    /// Reads until the connection is closed.
    fn read(stream: &mut impl BufRead) -> Answer {
        let mut answer = Answer::read_head(stream);
        stream.read_to_end(&mut answer.body).unwrap();
        answer
    }

    fn header(&self, name: &str) -> &str {
        self.headers.get(name).map_or("", String::as_str)
    }

    /// Returns the status, `Content-Range` and `Content-Length`.
    fn range(&self) -> (u16, &str, &str) {
        (self.status, self.header("content-range"), self.header("content-length"))
    }

    fn text(&self) -> &str {
        std::str::from_utf8(&self.body).unwrap()
    }

    fn json(&self) -> Value {
        serde_json::from_slice(&self.body).unwrap()
    }
}

/// Returns the files of the player by their names on the site.
pub fn player() -> BTreeMap<String, PathBuf> {
    let below = crate::repository_rules::files_below("viewer/dist")
        .into_iter()
        .map(|path| crate::repository_rules::root().join(path));
    let folder = crate::repository_rules::root().join("viewer/dist");
    below.map(|path| (path.strip_prefix(&folder).unwrap().to_str().unwrap().to_owned(), path)).collect()
}

/// Returns the size of all files below a folder, in bytes.
pub fn bytes_below(folder: &Path) -> u64 {
    let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap());
    let bytes = entries.map(|entry| match entry.file_type().unwrap().is_dir() {
        true => bytes_below(&entry.path()),
        false => entry.metadata().unwrap().len(),
    });
    bytes.sum()
}

#[test]
fn the_page_and_the_film_are_served_and_described() {
    let folder = place();
    let server = Server::start(folder.path(), "a.lfold");
    let film = fs::read(folder.path().join("a.lfold")).unwrap();
    let answer = server.get("/film.lfold");
    assert_eq!((answer.status, &answer.body), (200, &film));
    assert_eq!(answer.header("content-type"), "application/octet-stream");
    assert_eq!(answer.header("content-length"), film.len().to_string());
    assert!(answer.header("etag").starts_with('"') && answer.header("etag").ends_with('"'), "a strong tag");
    let described = server.get("/film.json");
    let expected = json!({"kind": "lfold", "url": "film.lfold", "name": "a.lfold", "bytes": film.len()});
    assert_eq!((described.json(), described.header("content-type")), (expected, "application/json"));
    let files = player();
    assert!(files.contains_key("index.html") && files.len() > 2, "{files:?}");
    for (name, path) in &files {
        let answer = server.get(&format!("/{name}"));
        assert_eq!((answer.status, &answer.body), (200, &fs::read(path).unwrap()), "{name}");
        assert_ne!(answer.header("content-type"), "", "{name}");
    }
    let page = server.get("/?eye=0,1.5,0");
    assert_eq!((page.status, page.header("content-type")), (200, "text/html; charset=utf-8"));
    assert_eq!(page.body, fs::read(&files["index.html"]).unwrap());
}

#[test]
fn every_answer_forbids_what_the_page_does_not_need() {
    let folder = place();
    let server = Server::start(folder.path(), "a.lfold");
    let tag = server.get("/film.lfold").header("etag").to_owned();
    let answers = [
        (200, server.get("/")),
        (200, server.get("/film.json")),
        (206, server.ask("GET", "/film.lfold", "Range: bytes=0-0\r\n")),
        (304, server.ask("GET", "/film.lfold", &format!("If-None-Match: {tag}\r\n"))),
        (404, server.get("/none")),
        (405, server.ask("POST", "/", "Content-Length: 0\r\n")),
        (416, server.ask("GET", "/film.lfold", "Range: bytes=99999999-\r\n")),
        (421, server.raw("GET / HTTP/1.1\r\nHost: evil.example\r\nConnection: close\r\n\r\n")),
    ];
    for (status, answer) in answers {
        assert_eq!(answer.status, status, "{answer:?}");
        let policy = answer.header("content-security-policy");
        assert!(policy.starts_with("default-src 'none'; script-src 'self' 'wasm-unsafe-eval';"), "{status}: {policy}");
        assert!(policy.contains("frame-ancestors 'none'") && !policy.contains("'unsafe"), "{status}: {policy}");
        let rows = [
            ("x-content-type-options", "nosniff"),
            ("referrer-policy", "no-referrer"),
            ("cross-origin-opener-policy", "same-origin"),
            ("cross-origin-resource-policy", "same-origin"),
            ("cache-control", "no-cache"),
            ("accept-ranges", "bytes"),
        ];
        for (name, value) in rows {
            assert_eq!(answer.header(name), value, "{status}: {name}");
        }
        let permissions = answer.header("permissions-policy");
        assert!(permissions.contains("gamepad=(self), xr-spatial-tracking=(self)"), "{status}: {permissions}");
    }
}

#[test]
fn ranges_are_parts_of_the_file() {
    let folder = place();
    let server = Server::start(folder.path(), "a.lfold");
    let film = fs::read(folder.path().join("a.lfold")).unwrap();
    let all = film.len();
    let part = |first: usize, last: usize| (206, format!("bytes {first}-{last}/{all}"), first..last + 1);
    // Other forms of the header are tested in src/cli/serve/range.rs.
    let rows = [
        ("bytes=0-15".to_owned(), part(0, 15)),
        (format!("bytes=5-{}", all + 5), part(5, all - 1)),
        ("bytes=-40".to_owned(), part(all - 40, all - 1)),
        ("bytes=0-1,4-5".to_owned(), (200, String::new(), 0..all)),
    ];
    for (range, (status, content_range, span)) in rows {
        let answer = server.ask("GET", "/film.lfold", &format!("Range: {range}\r\n"));
        assert_eq!(answer.range(), (status, content_range.as_str(), span.len().to_string().as_str()), "{range}");
        assert_eq!(answer.body, film[span], "{range}");
    }
    let beyond = server.ask("GET", "/film.lfold", &format!("Range: bytes={all}-\r\n"));
    assert_eq!((beyond.status, beyond.header("content-range")), (416, format!("bytes */{all}").as_str()));
    let twice = server.ask("GET", "/film.lfold", "Range: bytes=0-1\r\nRange: bytes=2-3\r\n");
    assert_eq!((twice.status, twice.body.len()), (200, all));
    // The page's files support ranges too.
    let part = server.ask("GET", "/", "Range: bytes=0-1\r\n");
    assert_eq!((part.status, part.body.as_slice()), (206, &b"<!"[..]));
}

#[test]
fn conditions_compare_tags() {
    let folder = place();
    let server = Server::start(folder.path(), "a.lfold");
    let bytes = fs::metadata(folder.path().join("a.lfold")).unwrap().len() as usize;
    let tag = server.get("/film.lfold").header("etag").to_owned();
    let of = |headers: String| {
        let answer = server.ask("GET", "/film.lfold", &headers);
        assert_eq!(answer.header("etag"), tag, "{headers}");
        (answer.status, answer.body.len())
    };
    for value in [tag.clone(), format!("W/{tag}"), "*".to_owned(), format!("\"x\", {tag}")] {
        assert_eq!(of(format!("If-None-Match: {value}\r\n")), (304, 0), "{value}");
    }
    assert_eq!(of("If-None-Match: \"x\"\r\n".to_owned()), (200, bytes));
    assert_eq!(of(format!("If-Range: {tag}\r\nRange: bytes=0-9\r\n")), (206, 10));
    for other in ["\"x\"".to_owned(), format!("W/{tag}"), "Sat, 29 Oct 1994 19:43:31 GMT".to_owned()] {
        assert_eq!(of(format!("If-Range: {other}\r\nRange: bytes=0-9\r\n")), (200, bytes), "{other}");
        assert_eq!(of(format!("If-Range: {other}\r\nRange: bytes={bytes}-\r\n")), (200, bytes), "{other}");
    }
    assert_eq!(of(format!("If-Match: {tag}\r\nRange: bytes=0-9\r\n")), (206, 10));
    assert_eq!(of("If-Match: \"x\"\r\nRange: bytes=0-9\r\n".to_owned()).0, 412);
    for path in ["/", "/film.json"] {
        let tag = server.get(path).header("etag").to_owned();
        assert_eq!(server.ask("GET", path, &format!("If-None-Match: {tag}\r\n")).status, 304, "{path}");
    }
}

#[test]
fn head_is_answered_like_get_without_a_body() {
    let folder = place();
    let server = Server::start(folder.path(), "a.lfold");
    for path in ["/", "/film.json", "/film.lfold", "/none"] {
        let [mut get, mut head] = ["GET", "HEAD"].map(|method| server.ask(method, path, ""));
        get.headers.remove("date");
        head.headers.remove("date");
        assert_eq!((head.status, &head.headers, head.body.len()), (get.status, &get.headers, 0), "{path}");
    }
    let ranged = server.ask("HEAD", "/film.lfold", "Range: bytes=0-0\r\n");
    assert_eq!((ranged.status, ranged.header("content-range")), (200, ""));
}

#[test]
fn no_other_path_has_an_answer() {
    let folder = place();
    fs::create_dir(folder.path().join("sub")).unwrap();
    fs::write(folder.path().join("sub/secret"), "secret").unwrap();
    let server = Server::start(folder.path(), "a.lfold");
    let long = format!("/{}", "x".repeat(8000));
    let above = format!("/{}film.lfold", "../".repeat(9));
    let paths = [
        "/a.lfold",
        "/film",
        "/film.glb",
        "/film.png",
        "/film.lfold/",
        "/FILM.LFOLD",
        "/./film.lfold",
        "//film.lfold",
        "/%66ilm.lfold",
        "/film%2Elfold",
        "/film.lfold%00",
        "/%00",
        "/sub/secret",
        "/sub%2Fsecret",
        "/..%2f..%2fetc%2fpasswd",
        "/../../../../etc/passwd",
        "/%2e%2e/%2e%2e/etc/passwd",
        "/etc/passwd",
        "/lightfield.json",
        "/index.html/",
        "/\\film.lfold",
        &above,
        &long,
    ];
    for path in paths {
        let answer = server.get(path);
        assert_eq!(answer.status, 404, "{path}: {answer:?}");
        assert!(answer.text().starts_with("404 "), "{path}: {answer:?}");
    }
}

#[test]
fn what_is_no_request_for_this_server_is_refused() {
    let folder = place();
    let server = Server::start(folder.path(), "a.lfold");
    for method in ["POST", "PUT", "DELETE", "OPTIONS", "PATCH", "TRACE", "ANY"] {
        let answer = server.ask(method, "/film.lfold", "Content-Length: 0\r\n");
        assert_eq!((answer.status, answer.header("allow")), (405, "GET, HEAD"), "{method}");
    }
    let of = |head: &str| server.raw(&format!("{head}Connection: close\r\n\r\n")).status;
    for host in ["localhost", "LocalHost:1", "127.0.0.1", "127.0.0.1:9", "[::1]:9"] {
        assert_eq!(of(&format!("GET / HTTP/1.1\r\nHost: {host}\r\n")), 200, "{host}");
    }
    for host in ["evil.example", "127.0.0.1.evil.example", "localhost.evil.example:80", "10.9.8.7", "0.0.0.0"] {
        assert_eq!(of(&format!("GET /film.lfold HTTP/1.1\r\nHost: {host}\r\n")), 421, "{host}");
    }
    assert_eq!(of("GET / HTTP/1.1\r\n"), 400);
    assert_eq!(of("GET / HTTP/1.1\r\nHost: localhost\r\nHost: localhost\r\n"), 400);
    assert_eq!(of("GET http://evil.example/ HTTP/1.1\r\nHost: localhost\r\n"), 421);
    assert_eq!(of("GET http://localhost/film.json HTTP/1.1\r\nHost: localhost\r\n"), 200);
    assert_eq!(of("GET /\0 HTTP/1.1\r\nHost: localhost\r\n"), 400);
    assert_eq!(of("no request\r\n"), 400);
    let fields: String = (0..200).map(|number| format!("X-{number}: a\r\n")).collect();
    assert_eq!(of(&format!("GET / HTTP/1.1\r\nHost: localhost\r\n{fields}")), 431);
    let mut stream = server.connect();
    // This exceeds what the server reads, so it may close the connection during the write.
    let _ = stream.write_all(format!("GET / HTTP/1.1\r\nHost: localhost\r\nX: {}", "x".repeat(64 << 10)).as_bytes());
    let mut answer = Vec::new();
    let _ = stream.read_to_end(&mut answer);
    assert!(answer.is_empty() || answer.starts_with(b"HTTP/1.1 431 "), "{}", String::from_utf8_lossy(&answer));
    assert_eq!(server.get("/").status, 200);
}

#[test]
fn a_connection_serves_one_request_after_the_other() {
    let folder = place();
    let server = Server::start(folder.path(), "a.lfold");
    let mut stream = BufReader::new(server.connect());
    for range in ["0-15", "16-20", "1-1"] {
        let head = format!("GET /film.lfold HTTP/1.1\r\nHost: localhost\r\nRange: bytes={range}\r\n\r\n");
        stream.get_mut().write_all(head.as_bytes()).unwrap();
        let answer = Answer::read_head(&mut stream);
        assert_eq!(answer.status, 206);
        let mut body = vec![0; answer.header("content-length").parse().unwrap()];
        stream.read_exact(&mut body).unwrap();
    }
}

#[test]
fn a_film_that_is_replaced_gets_another_tag() {
    let folder = place();
    let path = folder.path().join("a.lfold");
    let server = Server::start(folder.path(), "a.lfold");
    let before = server.get("/film.lfold").header("etag").to_owned();
    let mut other = fs::read(&path).unwrap();
    // Different bytes with the same length and time under the same name, as after an encoder replaced the file.
    let at = other.len() / 2;
    other[at] ^= 1;
    let time = fs::metadata(&path).unwrap().modified().unwrap();
    fs::write(folder.path().join("b"), &other).unwrap();
    File::options().write(true).open(folder.path().join("b")).unwrap().set_modified(time).unwrap();
    fs::rename(folder.path().join("b"), &path).unwrap();
    let answer = server.ask("GET", "/film.lfold", &format!("If-Range: {before}\r\nRange: bytes=0-9\r\n"));
    assert_eq!((answer.status, &answer.body), (200, &other));
    assert_ne!(answer.header("etag"), before);
    assert_eq!(server.ask("GET", "/film.lfold", &format!("If-Match: {before}\r\n")).status, 412);
    fs::write(&path, &other[..100]).unwrap();
    assert_eq!(server.get("/film.json").json()["bytes"], 100);
    assert_eq!(server.ask("GET", "/film.lfold", "Range: bytes=100-\r\n").header("content-range"), "bytes */100");
    fs::write(&path, "").unwrap();
    assert_eq!(server.get("/film.lfold").range(), (200, "", "0"));
    fs::remove_file(&path).unwrap();
    for name in ["/film.lfold", "/film.json"] {
        let gone = server.get(name);
        assert_eq!(gone.status, 404, "{name}");
        assert!(gone.text().contains("no longer exists"), "{name}: {}", gone.text());
    }
    assert_eq!(server.get("/").status, 200);
}

/// Exceeds the buffers of two sockets.
pub const LARGE: u32 = 64 << 20;

#[test]
fn a_film_that_changes_while_it_is_sent_ends_the_connection_before_its_length() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("large.glb");
    let change: [fn(&mut File); 2] = [
        |file| file.set_len(1 << 20).unwrap(),
        |file| {
            file.seek(SeekFrom::Start(1000)).unwrap();
            file.write_all(b"other").unwrap();
            file.set_modified(SystemTime::now()).unwrap();
        },
    ];
    for change in change {
        write_glb(&path, LARGE);
        let server = Server::start(folder.path(), "large.glb");
        let mut stream = BufReader::new(server.connect());
        stream.get_mut().write_all(b"GET /film.glb HTTP/1.1\r\nHost: localhost\r\n\r\n").unwrap();
        let answer = Answer::read_head(&mut stream);
        assert_eq!(answer.range(), (200, "", LARGE.to_string().as_str()));
        change(&mut File::options().write(true).open(&path).unwrap());
        let mut body = Vec::new();
        // Reading fails if the connection is reset and succeeds if it is closed; both are allowed.
        let _ = stream.read_to_end(&mut body);
        assert!(body.len() < LARGE as usize, "all of it was sent");
        assert_ne!(server.get("/film.json").status, 500);
    }
}

#[test]
fn quilts_are_served_with_their_layout() {
    let folder = TempDir::new().unwrap();
    let name = "a<b>_qs4x2a0.75.png";
    png::write_color8(&folder.path().join(name), &Plane::filled(12, 8, [1, 2, 3])).unwrap();
    let server = Server::start(folder.path(), name);
    let quilt = json!({"columns": 4, "rows": 2, "aspect": 0.75});
    let described = server.get("/film.json").json();
    assert_eq!((&described["kind"], &described["name"], &described["quilt"]), (&"quilt".into(), &name.into(), &quilt));
    let film = server.get("/film.png");
    assert_eq!(film.header("content-type"), "image/png");
    assert_eq!(film.body, fs::read(folder.path().join(name)).unwrap());
}

#[test]
fn the_address_is_reported_and_a_taken_port_refused() {
    let folder = place();
    let server = Server::start(folder.path(), "a.lfold --listen 0.0.0.0");
    assert_eq!(server.raw("GET / HTTP/1.1\r\nHost: 10.9.8.7:1\r\nConnection: close\r\n\r\n").status, 200);
    assert_eq!(server.raw("GET / HTTP/1.1\r\nHost: evil.example\r\nConnection: close\r\n\r\n").status, 421);
    let port = server.port.to_string();
    let output = lightfold(&["view", "a.lfold", "--listen", "0.0.0.0", "--port", &port, "--json"], folder.path());
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(75), "{said}");
    assert!(said.contains(&format!("0.0.0.0:{port}: ")), "{said}");
}

#[cfg(unix)]
#[test]
fn signals_end_a_server_without_a_complaint() {
    let folder = place();
    for name in ["-INT", "-TERM"] {
        let mut command = Command::new(env!("CARGO_BIN_EXE_lightfold"));
        command.args(["view", "a.lfold", "--json"]).current_dir(folder.path()).stdin(Stdio::null());
        let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        let mut out = BufReader::new(child.stdout.take().unwrap());
        let mut text = String::new();
        while !text.ends_with("}\n") {
            assert!(out.read_line(&mut text).unwrap() > 0, "{text}");
        }
        let report: Value = serde_json::from_str(&text).unwrap();
        assert_eq!(schemas::faults(&schemas::schema("view"), &report), [""; 0], "{report:#}");
        let address = report["address"].as_str().unwrap().strip_prefix("http://").unwrap().trim_end_matches('/');
        // An open connection does not prevent the server from exiting.
        let open = TcpStream::connect(address).unwrap();
        let signal = Command::new("kill").args([name, &child.id().to_string()]).status().unwrap();
        assert!(signal.success());
        assert_eq!(child.wait().unwrap().code(), Some(0), "{name}");
        let mut rest = String::new();
        out.read_to_string(&mut rest).unwrap();
        assert_eq!(rest, "", "a second document");
        drop(open);
    }
}

#[test]
fn what_cannot_be_played_is_refused() {
    let folder = place();
    let at = folder.path();
    fs::write(at.join("text.txt"), "no film").unwrap();
    fs::write(at.join("damaged.lfold"), "no container").unwrap();
    fs::write(at.join("cut.glb"), b"glTF\x02\0\0\0\xff\0\0\0").unwrap();
    fs::write(at.join("short.glb"), b"glTF").unwrap();
    fs::write(at.join("old.glb"), b"glTF\x01\0\0\0\x0c\0\0\0").unwrap();
    fs::write(at.join("damaged_qs1x1.png"), b"\x89PNG\r\n\x1a\n").unwrap();
    for name in ["junk.glb", "junk_qs1x1.PNG"] {
        fs::write(at.join(name), "junk").unwrap();
    }
    fs::write(at.join("other.json"), "{\"probes\": []}").unwrap();
    fs::copy(at.join("lightfield.json"), at.join("renamed")).unwrap();
    png::write_color8(&at.join("picture.png"), &Plane::filled(4, 4, [0, 0, 0])).unwrap();
    png::write_color8(&at.join("small_qs5x1.png"), &Plane::filled(4, 4, [0, 0, 0])).unwrap();
    for (words, expected) in [
        ("none.lfold", "none.lfold: "),
        ("text.txt", "text.txt: not a film: a container (.lfold), a simplified scene (.glb) or a quilt (.png)"),
        ("other.json", "other.json: not a film: "),
        (
            "damaged.lfold",
            "damaged.lfold: not a container, despite its name: copy it again, or write it with lightfold encode",
        ),
        ("junk.glb", "junk.glb: not a binary glTF file, despite"),
        ("junk_qs1x1.PNG", "junk_qs1x1.PNG: not a PNG picture, despite"),
        ("cut.glb", "cut.glb: truncated: the file has 12 of the 255 bytes"),
        ("short.glb", "short.glb: truncated: 4 bytes"),
        ("old.glb", "version 1; 2 was expected"),
        ("damaged_qs1x1.png", "damaged_qs1x1.png: a PNG picture that is damaged or truncated: copy it again"),
        ("picture.png", "picture.png: the name of the picture has no quilt layout"),
        ("small_qs5x1.png", "4x4 pixels, but its name states 5x1 tiles"),
        (".", "a dataset, where a film was expected: encode it with lightfold encode"),
        ("lightfield.json", "lightfield.json: a dataset"),
        ("renamed", "renamed: a dataset"),
        ("probe_00", "not a regular file"),
        ("-", "cannot read standard input"),
        ("a.lfold --port 65536", "65536"),
        ("a.lfold --listen localhost", "localhost"),
    ] {
        let output = lightfold(&["view"].into_iter().chain(words.split(' ')).collect::<Vec<_>>(), at);
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!((output.status.code(), output.stdout.len()), (Some(2), 0), "{words}: {said}");
        assert!(said.contains(expected), "{words}: {said}");
    }
    for more in ["--port 80", "--open", "--listen 127.0.0.1"] {
        assert!(
            !lightfold(&format!("view a.lfold --export b {more}").split(' ').collect::<Vec<_>>(), at).status.success()
        );
    }
    assert!(!at.join("b").exists());
    assert!(refused("view text.txt --export b", at).contains("not a film"));
    assert!(!at.join("b").exists());
}

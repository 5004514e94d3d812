//! The server: one thread for all connections, a few that read the file, and limits on both.

use std::convert::Infallible;
use std::net::{IpAddr, Ipv4Addr, Ipv6Addr, SocketAddr};
use std::sync::Arc;
use std::time::Duration;

use hyper::Request;
use hyper::body::Incoming;
use hyper::server::conn::http1;
use hyper::service::service_fn;
use hyper_util::rt::{TokioIo, TokioTimer};
use tokio::net::{TcpListener, TcpStream};
use tokio::runtime::Builder;
use tokio::sync::{Notify, Semaphore};
use tokio_io_timeout::TimeoutStream;

use super::answer::{Served, answer};
use super::film::Film;
use crate::error::{Error, Result};

/// Connections at a time; further ones wait until one ends.
const MAX_CONNECTIONS: usize = 256;
/// Threads that read the file.
const MAX_READERS: usize = 16;
/// Bytes of a request's head, at most.
const MAX_HEAD_BYTES: usize = 16 << 10;
/// How long a connection may take for the head of its next request, and be idle.
const HEAD_TIMEOUT: Duration = Duration::from_secs(10);
/// The same for connections that are accepted while more than half of [`MAX_CONNECTIONS`] are open: idle ones make room for others.
const CROWDED_HEAD_TIMEOUT: Duration = Duration::from_secs(2);
/// How long a client may take none of the bytes that wait for it.
const WRITE_TIMEOUT: Duration = Duration::from_secs(120);
/// Pause after a connection that could not be accepted, as where there are too many open files.
const ACCEPT_RETRY_DELAY: Duration = Duration::from_millis(50);

/// A server that is bound to its address.
#[derive(Debug)]
pub struct Server {
    listener: std::net::TcpListener,
    address: SocketAddr,
    film: Film,
}

/// Ends a server, from any thread.
#[derive(Debug, Clone, Default)]
pub struct Stop(Arc<Notify>);

impl Stop {
    /// Ends the server now, or as soon as it runs.
    pub fn stop(&self) {
        self.0.notify_one();
    }
}

impl Server {
    /// Binds an address; port 0 stands for a free one. Connections wait until [`Self::run`].
    pub fn bind(film: Film, address: SocketAddr) -> Result<Server> {
        let io = |error| Error::io(address.to_string(), error);
        let listener = std::net::TcpListener::bind(address).map_err(io)?;
        listener.set_nonblocking(true).map_err(io)?;
        let address = listener.local_addr().map_err(io)?;
        Ok(Server { listener, address, film })
    }

    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// The page's address for a browser on this machine.
    pub fn page(&self) -> String {
        let ip = match self.address.ip() {
            IpAddr::V4(ip) if ip.is_unspecified() => Ipv4Addr::LOCALHOST.into(),
            IpAddr::V6(ip) if ip.is_unspecified() => Ipv6Addr::LOCALHOST.into(),
            ip => ip,
        };
        format!("http://{}/", SocketAddr::new(ip, self.address.port()))
    }

    /// Serves until it is stopped, which ends all connections.
    pub fn run(self, stop: &Stop) -> Result<()> {
        let io = |error| Error::io(self.address.to_string(), error);
        let runtime = Builder::new_current_thread()
            .enable_io()
            .enable_time()
            .max_blocking_threads(MAX_READERS)
            .build()
            .map_err(io)?;
        let served = Arc::new(Served { film: self.film, bound: self.address.ip() });
        let ended = runtime.block_on(async {
            let listener = TcpListener::from_std(self.listener)?;
            tokio::spawn(accept(listener, served));
            stop.0.notified().await;
            Ok(())
        });
        // Without waiting for a file that cannot be read.
        runtime.shutdown_background();
        ended.map_err(io)
    }
}

async fn accept(listener: TcpListener, served: Arc<Served>) {
    let permits = Arc::new(Semaphore::new(MAX_CONNECTIONS));
    while let Ok(permit) = Arc::clone(&permits).acquire_owned().await {
        let Ok((stream, _)) = listener.accept().await else {
            tokio::time::sleep(ACCEPT_RETRY_DELAY).await;
            continue;
        };
        let served = Arc::clone(&served);
        let is_crowded = permits.available_permits() < MAX_CONNECTIONS / 2;
        let head_timeout = if is_crowded { CROWDED_HEAD_TIMEOUT } else { HEAD_TIMEOUT };
        tokio::spawn(async move {
            serve(stream, served, head_timeout).await;
            drop(permit);
        });
    }
}

async fn serve(stream: TcpStream, served: Arc<Served>, head_timeout: Duration) {
    // Without it the last bytes of an answer may wait for an acknowledgement of those before: slower, not wrong.
    let _ = stream.set_nodelay(true);
    let mut stream = TimeoutStream::new(stream);
    stream.set_write_timeout(Some(WRITE_TIMEOUT));
    let service = service_fn(|request: Request<Incoming>| {
        let served = Arc::clone(&served);
        async move { Ok::<_, Infallible>(answer(&served, &request.into_parts().0).await) }
    });
    let connection = http1::Builder::new()
        .timer(TokioTimer::new())
        .header_read_timeout(head_timeout)
        // A client that has sent its request may close its side.
        .half_close(true)
        .max_buf_size(MAX_HEAD_BYTES)
        .serve_connection(TokioIo::new(Box::pin(stream)), service);
    // A client that goes, or breaks the protocol, is its own affair.
    let _ = connection.await;
}

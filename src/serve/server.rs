//! The server: one thread for all connections, a few that read the file, and limits on both.

use std::convert::Infallible;
use std::io;
use std::net::{IpAddr, Ipv4Addr, Ipv6Addr, SocketAddr};
use std::sync::Arc;
use std::time::Duration;

use hyper::Request;
use hyper::body::Incoming;
use hyper::server::conn::http1;
use hyper::service::service_fn;
use hyper_util::rt::TokioIo;
use tokio::net::{TcpListener, TcpSocket, TcpStream};
use tokio::runtime::{Builder, Runtime};
use tokio::sync::Notify;

use super::answer::{Served, answer, is_out_of_files};
use super::answering::{AnswerMark, Answering};
use super::connections::{Connection, Connections, Limits};
use super::film::Film;
use super::watched::Watched;
use crate::error::{Error, Result};

/// Threads that read the file.
const MAX_READERS: usize = 16;
/// Bytes of a request's head, at most.
const MAX_HEAD_BYTES: usize = 16 << 10;
/// Bytes that the system holds for a client, which may read none of them.
const SEND_BUFFER_BYTES: u32 = 256 << 10;
/// Connections that the system keeps until the server accepts them.
const BACKLOG: u32 = 1024;
/// Pause after a connection that could not be accepted, as where there are too many open files.
const ACCEPT_RETRY_DELAY: Duration = Duration::from_millis(5);

/// A server that is bound to its address.
#[derive(Debug)]
pub struct Server {
    runtime: Runtime,
    listener: TcpListener,
    address: SocketAddr,
    film: Film,
    limits: Limits,
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
    pub fn bind(film: Film, address: SocketAddr, limits: Limits) -> Result<Server> {
        let io = |error| Error::io(address.to_string(), error);
        let runtime = Builder::new_current_thread()
            .enable_io()
            .enable_time()
            .max_blocking_threads(MAX_READERS)
            .build()
            .map_err(io)?;
        let listener = {
            let _within = runtime.enter();
            listen(address).map_err(io)?
        };
        let address = listener.local_addr().map_err(io)?;
        Ok(Server { runtime, listener, address, film, limits })
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
    pub fn run(self, stop: &Stop) {
        let connections = Arc::new(Connections::new(self.limits));
        let served = Arc::new(Served::new(self.film, self.address.ip(), Arc::clone(&connections)));
        self.runtime.block_on(async {
            tokio::spawn(accept(self.listener, served, Arc::clone(&connections)));
            tokio::spawn(sweep(connections));
            stop.0.notified().await;
        });
        // Without waiting for a file that cannot be read.
        self.runtime.shutdown_background();
    }
}

fn listen(address: SocketAddr) -> io::Result<TcpListener> {
    let socket = if address.is_ipv4() { TcpSocket::new_v4() } else { TcpSocket::new_v6() }?;
    // A server that has just ended keeps the port else. Windows means something else by the option.
    #[cfg(unix)]
    socket.set_reuseaddr(true)?;
    // Connections inherit it where the system lets them; where it does not, they hold what it gives them.
    let _ = socket.set_send_buffer_size(SEND_BUFFER_BYTES);
    socket.bind(address)?;
    socket.listen(BACKLOG)
}

/// Accepts every connection at once, so that none waits for another.
async fn accept(listener: TcpListener, served: Arc<Served>, connections: Arc<Connections>) {
    loop {
        match listener.accept().await {
            Ok((stream, client)) => connections.add(client.ip(), |connection| {
                let (served, connections) = (Arc::clone(&served), Arc::clone(&connections));
                let task = tokio::spawn(async move {
                    serve(stream, served, Arc::clone(&connection)).await;
                    connections.remove(&connection);
                });
                task.abort_handle()
            }),
            // The client went away before.
            Err(error) if error.kind() == io::ErrorKind::ConnectionAborted => {}
            Err(error) => {
                if is_out_of_files(&error) {
                    connections.out_of_files();
                }
                tokio::time::sleep(ACCEPT_RETRY_DELAY).await;
            }
        }
    }
}

async fn sweep(connections: Arc<Connections>) {
    loop {
        tokio::time::sleep(connections.sweep_interval()).await;
        connections.sweep();
    }
}

async fn serve(stream: TcpStream, served: Arc<Served>, connection: Arc<Connection>) {
    // Without it the last bytes of an answer may wait for an acknowledgement of those before: slower, not wrong.
    let _ = stream.set_nodelay(true);
    let stream = Watched { stream, connection: Arc::clone(&connection) };
    let service = service_fn(|request: Request<Incoming>| {
        let (served, mark) = (Arc::clone(&served), AnswerMark::begin(&connection));
        async move {
            let response = answer(&served, &request.into_parts().0).await;
            Ok::<_, Infallible>(response.map(|body| Answering { body, _mark: mark }))
        }
    });
    let connection = http1::Builder::new()
        // A client that has sent its request may close its side.
        .half_close(true)
        .max_buf_size(MAX_HEAD_BYTES)
        .serve_connection(TokioIo::new(stream), service);
    // A client that goes, or breaks the protocol, is its own affair.
    let _ = connection.await;
}

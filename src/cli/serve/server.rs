//! The server: one thread for all connections, a few threads that read the file, and limits on both.

use std::convert::Infallible;
use std::io;
use std::net::{IpAddr, Ipv4Addr, Ipv6Addr, SocketAddr};
use std::pin::Pin;
use std::sync::Arc;
use std::task::{Context, Poll};
use std::time::Duration;

use hyper::Request;
use hyper::body::{Body as HttpBody, Bytes, Frame, Incoming, SizeHint};
use hyper::server::conn::http1;
use hyper::service::service_fn;
use hyper_util::rt::TokioIo;
use tokio::net::{TcpListener, TcpSocket, TcpStream};
use tokio::runtime::{Builder, Runtime};
use tokio::sync::Notify;

use super::answer::{Body, Served, answer, is_out_of_files};
use super::connections::{Connection, Connections, Limits};
use super::film::Film;
use super::watched::Watched;
use codec::error::{Error, Result};

/// Maximum number of threads that read the file.
const MAX_READERS: usize = 16;
/// Maximum bytes of a request's head.
const MAX_HEAD_BYTES: usize = 16 << 10;
/// Send buffer of a connection in the system, which a client may leave unread.
const SEND_BUFFER_BYTES: u32 = 256 << 10;
/// Maximum connections that the system queues until the server accepts them.
const BACKLOG: u32 = 1024;
/// Delay after a failure to accept a connection, for example when there are too many open files.
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

/// Stops a server, from any thread.
#[derive(Debug, Clone, Default)]
pub struct Stop(Arc<Notify>);

impl Stop {
    /// Stops the server now, or as soon as it runs.
    pub fn stop(&self) {
        self.0.notify_one();
    }
}

impl Server {
    /// Binds an address; port 0 selects a free one. Connections are queued until [`Self::run`].
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

    /// Returns the page's address for a browser on this machine.
    pub fn page(&self) -> String {
        let ip = match self.address.ip() {
            IpAddr::V4(ip) if ip.is_unspecified() => Ipv4Addr::LOCALHOST.into(),
            IpAddr::V6(ip) if ip.is_unspecified() => Ipv6Addr::LOCALHOST.into(),
            ip => ip,
        };
        format!("http://{}/", SocketAddr::new(ip, self.address.port()))
    }

    /// Serves until stopped, which closes all connections.
    pub fn run(self, stop: &Stop) {
        let connections = Arc::new(Connections::new(self.limits));
        let served = Arc::new(Served::new(self.film, self.address.ip(), Arc::clone(&connections)));
        let prepared = Arc::clone(&served);
        self.runtime.block_on(async {
            tokio::spawn(accept(self.listener, served, Arc::clone(&connections)));
            tokio::spawn(sweep(connections));
            tokio::task::spawn_blocking(move || prepared.prepare());
            stop.0.notified().await;
        });
        // Does not wait for blocking reads.
        self.runtime.shutdown_background();
    }
}

fn listen(address: SocketAddr) -> io::Result<TcpListener> {
    let socket = if address.is_ipv4() { TcpSocket::new_v4() } else { TcpSocket::new_v6() }?;
    // Without this option a server that has just exited blocks the port. On Windows the option has a different meaning.
    #[cfg(unix)]
    socket.set_reuseaddr(true)?;
    // Accepted connections inherit the buffer size if the system allows; otherwise they use its default.
    let _ = socket.set_send_buffer_size(SEND_BUFFER_BYTES);
    socket.bind(address)?;
    socket.listen(BACKLOG)
}

/// Accepts every connection immediately, so that none waits for another.
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
            // The client disconnected before the connection was accepted.
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
    // Without it the last bytes of a response may wait for an acknowledgement of the previous ones: slower, but still correct.
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
        // A client may close its sending side after its request.
        .half_close(true)
        .max_buf_size(MAX_HEAD_BYTES)
        .serve_connection(TokioIo::new(stream), service);
    // A client that disconnects or breaks the protocol is not an error of the server.
    let _ = connection.await;
}

/// A body that is being sent. Dropping it ends the response.
pub struct Answering {
    pub body: Body,
    pub _mark: AnswerMark,
}

/// Marks a response in progress, from the complete head of its request to its end.
pub struct AnswerMark(Arc<Connection>);

impl AnswerMark {
    pub fn begin(connection: &Arc<Connection>) -> AnswerMark {
        connection.begin_answer();
        AnswerMark(Arc::clone(connection))
    }
}

impl Drop for AnswerMark {
    fn drop(&mut self) {
        self.0.end_answer();
    }
}

impl HttpBody for Answering {
    type Data = Bytes;
    type Error = Box<dyn std::error::Error + Send + Sync>;

    fn poll_frame(mut self: Pin<&mut Self>, cx: &mut Context<'_>) -> Poll<Option<Result<Frame<Bytes>, Self::Error>>> {
        Pin::new(&mut self.body).poll_frame(cx)
    }

    fn is_end_stream(&self) -> bool {
        self.body.is_end_stream()
    }

    fn size_hint(&self) -> SizeHint {
        self.body.size_hint()
    }
}

//! Open connections, and the choice of the one to close when there are too many.
//!
//! A connection makes progress when the head of a request is complete, when a response ends, and with each [`PROGRESS_BYTES`]
//! of responses that the client takes; fewer bytes are no progress. A connection that waits for its client without progress is
//! closed after [`Limits::progress_timeout`]. A new connection is always accepted: if there are [`Limits::max_connections`],
//! the one that [`worst`] selects is closed for it.

use std::collections::BTreeMap;
use std::net::{IpAddr, Ipv6Addr};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use tokio::task::AbortHandle;

/// Bytes of responses that count as progress once a client has taken them.
const PROGRESS_BYTES: u64 = 64 << 10;
/// Number of connections of one network above which that network loses connections first. Browsers open six to a server.
const FAIR_SHARE: usize = 32;
/// Open files that are kept free for reading the film, once the system has run out of file descriptors.
const FREE_FILES: usize = 20;
/// Time until closed connections have released their file descriptors.
const FILES_RETURN: Duration = Duration::from_millis(10);

/// Limits of a server.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Limits {
    /// Maximum simultaneous connections, at least 1.
    pub max_connections: usize,
    /// Maximum time that a connection may wait for its client without progress.
    pub progress_timeout: Duration,
}

impl Default for Limits {
    fn default() -> Limits {
        Limits { max_connections: 256, progress_timeout: Duration::from_secs(10) }
    }
}

/// All open connections.
#[derive(Debug)]
pub struct Connections {
    limits: Limits,
    table: Mutex<Table>,
}

#[derive(Debug)]
struct Table {
    next_id: u64,
    open: BTreeMap<u64, Open>,
    /// Number of connections that the system has file descriptors for; at most `max_connections`.
    capacity: usize,
    /// Time at which the system last ran out of file descriptors.
    out_of_files: Option<Instant>,
}

#[derive(Debug)]
struct Open {
    connection: Arc<Connection>,
    task: AbortHandle,
}

/// A connection and its progress.
#[derive(Debug)]
pub struct Connection {
    id: u64,
    /// Network of the client: see [`network`].
    network: IpAddr,
    activity: Mutex<Activity>,
}

#[derive(Debug, Clone, Copy)]
struct Activity {
    /// Time of the last progress, or of the beginning.
    progress: Instant,
    /// Bytes taken since the last progress.
    taken_bytes: u64,
    /// True while a response has not ended.
    is_answering: bool,
    /// True while the client takes no bytes.
    is_blocked: bool,
    /// True if the server closes the connection and drops its unsent bytes.
    is_given_up: bool,
}

impl Activity {
    /// True if the client has to send a head or take bytes.
    fn waits_for_client(&self) -> bool {
        self.is_blocked || !self.is_answering
    }
}

impl Connection {
    fn activity(&self) -> MutexGuard<'_, Activity> {
        self.activity.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Records that the head of a request is complete.
    pub fn begin_answer(&self) {
        let mut activity = self.activity();
        activity.is_answering = true;
        activity.progress = Instant::now();
    }

    /// Records that all bytes of a response have been produced, or that it was dropped.
    pub fn end_answer(&self) {
        let mut activity = self.activity();
        activity.is_answering = false;
        activity.progress = Instant::now();
    }

    /// Records bytes that the client took.
    pub fn took(&self, bytes: u64) {
        let mut activity = self.activity();
        activity.is_blocked = false;
        activity.taken_bytes += bytes;
        if activity.taken_bytes >= PROGRESS_BYTES {
            activity.taken_bytes = 0;
            activity.progress = Instant::now();
        }
    }

    /// Records that the client takes none of the pending bytes.
    pub fn blocked(&self) {
        self.activity().is_blocked = true;
    }

    pub fn is_given_up(&self) -> bool {
        self.activity().is_given_up
    }
}

impl Connections {
    pub fn new(limits: Limits) -> Connections {
        let table =
            Table { next_id: 0, open: BTreeMap::new(), capacity: limits.max_connections.max(1), out_of_files: None };
        Connections { limits, table: Mutex::new(table) }
    }

    fn table(&self) -> MutexGuard<'_, Table> {
        self.table.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Adds a connection, closing others if there are too many. `start` spawns its task.
    pub fn add(&self, client: IpAddr, start: impl FnOnce(Arc<Connection>) -> AbortHandle) {
        let mut table = self.table();
        let capacity = table.capacity;
        table.close_above(capacity.saturating_sub(1));
        let id = table.next_id;
        table.next_id += 1;
        let activity = Activity {
            progress: Instant::now(),
            taken_bytes: 0,
            is_answering: false,
            is_blocked: false,
            is_given_up: false,
        };
        let connection = Arc::new(Connection { id, network: network(client), activity: Mutex::new(activity) });
        let task = start(Arc::clone(&connection));
        table.open.insert(id, Open { connection, task });
    }

    /// Removes a connection that has ended.
    pub fn remove(&self, connection: &Connection) {
        self.table().open.remove(&connection.id);
    }

    /// Handles running out of file descriptors: closes as many connections as reading the film needs descriptors, and lowers
    /// the capacity for a while. Further calls within `FILES_RETURN` are ignored, because they can use the same descriptors.
    pub fn out_of_files(&self) {
        let mut table = self.table();
        let now = Instant::now();
        if table.out_of_files.is_some_and(|before| now.duration_since(before) < FILES_RETURN) {
            return;
        }
        table.out_of_files = Some(now);
        table.capacity = table.open.len().saturating_sub(FREE_FILES).max(1);
        let capacity = table.capacity;
        table.close_above(capacity);
    }

    /// Returns the time between calls of [`Self::sweep`].
    pub fn sweep_interval(&self) -> Duration {
        (self.limits.progress_timeout / 8).max(Duration::from_millis(1))
    }

    /// Closes connections that have waited for their client longer than the timeout.
    pub fn sweep(&self) {
        let (now, timeout) = (Instant::now(), self.limits.progress_timeout);
        let mut table = self.table();
        table.capacity = (table.capacity + 1).min(self.limits.max_connections.max(1));
        let late = table.open.iter().filter(|(_, open)| {
            let activity = open.connection.activity();
            activity.waits_for_client() && now.saturating_duration_since(activity.progress) > timeout
        });
        let late: Vec<u64> = late.map(|(id, _)| *id).collect();
        late.into_iter().for_each(|id| table.close(id));
    }
}

impl Table {
    fn close_above(&mut self, count: usize) {
        while self.open.len() > count {
            let all = self.open.values().map(|Open { connection, .. }| (&**connection, *connection.activity()));
            let Some(id) = worst(&all.collect::<Vec<_>>()) else { return };
            self.close(id);
        }
    }

    fn close(&mut self, id: u64) {
        if let Some(Open { connection, task }) = self.open.remove(&id) {
            connection.activity().is_given_up = true;
            task.abort();
        }
    }
}

/// Selects the connection to close first: one that waits for its client rather than for the server; among these, one of the
/// network with the most connections, if it has more than [`FAIR_SHARE`]; among these, the one without progress for the longest
/// time.
fn worst(open: &[(&Connection, Activity)]) -> Option<u64> {
    let mut counts: BTreeMap<IpAddr, usize> = BTreeMap::new();
    open.iter().for_each(|(connection, _)| *counts.entry(connection.network).or_default() += 1);
    let rank = |(connection, activity): &&(&Connection, Activity)| {
        let share = counts.get(&connection.network).copied().unwrap_or_default().max(FAIR_SHARE);
        (activity.waits_for_client(), share, std::cmp::Reverse((activity.progress, connection.id)))
    };
    open.iter().max_by_key(rank).map(|(connection, _)| connection.id)
}

/// Returns the network of a client: its IPv4 address, or the /64 network of its IPv6 address, all of which one machine may use.
fn network(address: IpAddr) -> IpAddr {
    match address.to_canonical() {
        IpAddr::V6(v6) => IpAddr::V6(Ipv6Addr::from_bits(v6.to_bits() >> 64 << 64)),
        v4 => v4,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Connections of these addresses, with the seconds since their last progress.
    struct Rows(Vec<(Connection, Activity)>);

    impl Rows {
        fn of(rows: &[(&str, u64)]) -> Rows {
            let now = Instant::now() + Duration::from_secs(1000);
            let row = |(id, (address, ago)): (usize, &(&str, u64))| {
                let activity = Activity {
                    progress: now - Duration::from_secs(*ago),
                    taken_bytes: 0,
                    is_answering: false,
                    is_blocked: false,
                    is_given_up: false,
                };
                let network = network(address.parse().unwrap());
                (Connection { id: id as u64, network, activity: Mutex::new(activity) }, activity)
            };
            Rows(rows.iter().enumerate().map(row).collect())
        }

        fn worst(&self) -> Option<u64> {
            worst(&self.0.iter().map(|(connection, activity)| (connection, *activity)).collect::<Vec<_>>())
        }
    }

    #[test]
    fn least_progress_is_closed_first() {
        let mut rows = Rows::of(&[("10.0.0.1", 3), ("10.0.0.2", 9), ("10.0.0.3", 5)]);
        assert_eq!(rows.worst(), Some(1));
        // The server is working on the response, so the client is not at fault.
        rows.0[1].1.is_answering = true;
        assert_eq!(rows.worst(), Some(2));
        rows.0[1].1.is_blocked = true;
        assert_eq!(rows.worst(), Some(1));
        rows.0.iter_mut().for_each(|row| (row.1.is_answering, row.1.is_blocked) = (true, false));
        assert_eq!(rows.worst(), Some(1), "one has to go");
        assert_eq!(Rows::of(&[]).worst(), None);
        assert_eq!(Rows::of(&[("::1", 1), ("::1", 1)]).worst(), Some(0), "the elder of two");
    }

    #[test]
    fn addresses_above_their_share_lose_connections_first() {
        let mut rows = vec![("10.0.0.1", 1); FAIR_SHARE];
        rows.push(("10.0.0.2", 99));
        assert_eq!(Rows::of(&rows).worst(), Some(FAIR_SHARE as u64), "a share is no fault");
        rows.push(("::ffff:10.0.0.1", 2));
        assert_eq!(Rows::of(&rows).worst(), Some(FAIR_SHARE as u64 + 1));
        let addresses: Vec<String> = (0..=FAIR_SHARE).map(|number| format!("2001:db8::{number:x}")).collect();
        let mut rows: Vec<(&str, u64)> = addresses.iter().map(|address| (address.as_str(), 1)).collect();
        rows.push(("2001:db8:0:1::1", 99));
        assert_eq!(Rows::of(&rows).worst(), Some(0), "addresses of one network");
    }

    #[test]
    fn bytes_are_progress_by_the_piece() {
        let rows = Rows::of(&[("10.0.0.1", 0)]);
        let connection = &rows.0[0].0;
        let began = connection.activity().progress - Duration::from_secs(1000);
        connection.activity().progress = began;
        connection.blocked();
        for _ in 1..PROGRESS_BYTES {
            connection.took(1);
        }
        assert_eq!(connection.activity().progress, began, "a byte now and then");
        connection.took(1);
        assert!(connection.activity().progress > began && !connection.activity().is_blocked);
    }
}

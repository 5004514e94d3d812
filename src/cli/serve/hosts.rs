//! Checks the host that a request names, against DNS rebinding: a page of another site can map its own name to the address of
//! this machine and then read the responses of a local server to that name. So the server only responds to addresses and to
//! `localhost`.

use std::net::IpAddr;

use hyper::header::HOST;
use hyper::http::request::Parts;
use hyper::http::uri::Authority;

/// Result of comparing a request's host with a server at `bound`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Addressee {
    Ours,
    /// A name that is not one of the server's.
    Another,
    /// `Host` is missing, repeated or malformed.
    Unclear,
}

/// Checks `Host`, and the request target if it is absolute. The port is ignored, because it may be forwarded.
pub fn addressee(head: &Parts, bound: IpAddr) -> Addressee {
    let mut hosts = head.headers.get_all(HOST).iter();
    let (Some(host), None) = (hosts.next(), hosts.next()) else { return Addressee::Unclear };
    let Some(host) = host.to_str().ok().and_then(|text| text.parse::<Authority>().ok()) else {
        return Addressee::Unclear;
    };
    let are_ours = [Some(&host), head.uri.authority()].into_iter().flatten().all(|name| is_ours(name, bound));
    if are_ours { Addressee::Ours } else { Addressee::Another }
}

/// True if a name is `localhost`, a loopback address, or the bound address; any address if the server listens on all.
fn is_ours(name: &Authority, bound: IpAddr) -> bool {
    let host = name.host();
    if name.as_str().contains('@') {
        return false;
    }
    match host.trim_start_matches('[').trim_end_matches(']').parse::<IpAddr>() {
        Ok(address) => address.is_loopback() || address == bound || bound.is_unspecified(),
        Err(_) => host.eq_ignore_ascii_case("localhost"),
    }
}

#[cfg(test)]
mod tests {
    use hyper::Request;

    use super::*;

    fn of(target: &str, hosts: &[&str], bound: &str) -> Addressee {
        let mut request = Request::builder().uri(target);
        for host in hosts {
            request = request.header(HOST, *host);
        }
        addressee(&request.body(()).unwrap().into_parts().0, bound.parse().unwrap())
    }

    #[test]
    fn names_of_other_sites_are_not_ours() {
        for host in ["127.0.0.1:80", "127.0.0.1", "localhost:9000", "LOCALHOST", "[::1]:80"] {
            assert_eq!(of("/", &[host], "127.0.0.1"), Addressee::Ours, "{host}");
        }
        for host in ["evil.example", "127.0.0.1.evil.example", "localhost.evil.example:80", "10.0.0.1", "a@127.0.0.1"] {
            assert_eq!(of("/", &[host], "127.0.0.1"), Addressee::Another, "{host}");
        }
        assert_eq!(of("/", &["10.0.0.1:80"], "10.0.0.1"), Addressee::Ours);
        assert_eq!(of("/", &["10.0.0.1:80"], "0.0.0.0"), Addressee::Ours);
        assert_eq!(of("/", &["[fe80::1]:80"], "::"), Addressee::Ours);
        assert_eq!(of("/", &["evil.example"], "0.0.0.0"), Addressee::Another);
    }

    #[test]
    fn one_host_is_named_and_the_target_counts_too() {
        for hosts in [&[][..], &["localhost", "localhost"], &[""], &["a b"], &["localhost/"]] {
            assert_eq!(of("/", hosts, "127.0.0.1"), Addressee::Unclear, "{hosts:?}");
        }
        assert_eq!(of("http://localhost/", &["localhost"], "127.0.0.1"), Addressee::Ours);
        assert_eq!(of("http://evil.example/", &["localhost"], "127.0.0.1"), Addressee::Another);
    }
}

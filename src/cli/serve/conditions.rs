//! Conditional requests (RFC 9110, 13): the headers that compare entity tags. The server sends no `Last-Modified`, so
//! conditions on dates never match.

use hyper::HeaderMap;
use hyper::header::{HeaderName, IF_MATCH, IF_NONE_MATCH, IF_RANGE};

/// Result of evaluating a request's conditions.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    Send,
    /// The client has the current representation: 304.
    NotModified,
    /// The precondition does not hold: 412.
    Failed,
}

/// Compares the headers with the strong tag of the representation, in the order of RFC 9110, 13.2.2.
pub fn verdict(headers: &HeaderMap, tag: &str) -> Verdict {
    if lists(headers, IF_MATCH, |listed| listed == tag) == Some(false) {
        return Verdict::Failed;
    }
    let is_same = |listed: &str| listed.strip_prefix("W/").unwrap_or(listed) == tag;
    match lists(headers, IF_NONE_MATCH, is_same) {
        Some(true) => Verdict::NotModified,
        _ => Verdict::Send,
    }
}

/// True if a range request may be answered with a part: `If-Range` is absent or equals the tag.
pub fn allows_part(headers: &HeaderMap, tag: &str) -> bool {
    headers.get_all(IF_RANGE).iter().all(|value| value.as_bytes() == tag.as_bytes())
}

/// True if a header lists a matching tag or `*`; `None` if the header is absent. Tags that contain a comma are split at it;
/// tags of this server contain none.
fn lists(headers: &HeaderMap, name: HeaderName, matches: impl Fn(&str) -> bool) -> Option<bool> {
    let mut values = headers.get_all(name).iter().peekable();
    values.peek()?;
    let mut tags = values.filter_map(|value| value.to_str().ok()).flat_map(|value| value.split(',')).map(str::trim);
    Some(tags.any(|listed| listed == "*" || matches(listed)))
}

#[cfg(test)]
mod tests {
    use hyper::header::HeaderValue;

    use super::*;

    fn with(rows: &[(HeaderName, &'static str)]) -> HeaderMap {
        let mut headers = HeaderMap::new();
        for (name, value) in rows {
            headers.append(name, HeaderValue::from_static(value));
        }
        headers
    }

    #[test]
    fn tags_decide_in_the_order_of_the_standard() {
        let of = |rows: &[(HeaderName, &'static str)]| verdict(&with(rows), "\"a-1\"");
        assert_eq!(of(&[]), Verdict::Send);
        for same in ["\"a-1\"", "W/\"a-1\"", "*", "\"b\", \"a-1\"", "\"b\",W/\"a-1\""] {
            assert_eq!(of(&[(IF_NONE_MATCH, same)]), Verdict::NotModified, "{same}");
        }
        assert_eq!(of(&[(IF_NONE_MATCH, "\"b\""), (IF_NONE_MATCH, "\"a-1\"")]), Verdict::NotModified);
        for other in ["\"a\"", "a-1", "", "w/\"a-1\""] {
            assert_eq!(of(&[(IF_NONE_MATCH, other)]), Verdict::Send, "{other}");
        }
        for same in ["\"a-1\"", "*", "\"b\", \"a-1\""] {
            assert_eq!(of(&[(IF_MATCH, same)]), Verdict::Send, "{same}");
        }
        for other in ["\"b\"", "W/\"a-1\"", ""] {
            assert_eq!(of(&[(IF_MATCH, other), (IF_NONE_MATCH, "*")]), Verdict::Failed, "{other}");
        }
    }

    #[test]
    fn parts_are_of_the_same_file_only() {
        let of = |rows: &[(HeaderName, &'static str)]| allows_part(&with(rows), "\"a\"");
        assert!(of(&[]) && of(&[(IF_RANGE, "\"a\"")]));
        for other in ["W/\"a\"", "\"b\"", "a", "*", "\"a\", \"b\"", "Sat, 29 Oct 1994 19:43:31 GMT"] {
            assert!(!of(&[(IF_RANGE, other)]), "{other}");
        }
    }
}

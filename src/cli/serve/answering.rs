//! Response body that records when the response ends.

use std::pin::Pin;
use std::sync::Arc;
use std::task::{Context, Poll};

use hyper::body::{Body as HttpBody, Bytes, Frame, SizeHint};

use super::answer::Body;
use super::connections::Connection;

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

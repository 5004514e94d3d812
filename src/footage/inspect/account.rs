//! Account of a container.

use crate::account::{Account, listed};
use codec::decode::{Decoder, StreamInfo};
use codec::error::escaped;
use codec::streams::FootageInfo;
use codec::streams::shard::{SHARD, SHARD_FOOTAGE};

/// Returns the account of a container of which some streams are inspected: probes, streams and attributes. Streams that are not
/// inspected, and attributes that this version does not know, are left out.
pub fn account(decoder: &Decoder, streams: &[&StreamInfo]) -> Account {
    let mut account = Account::default();
    let name = |stream: &StreamInfo| {
        format!("{} {}/{}", stream.kind.name(), escaped(&decoder.probe(stream).name), stream.face.name())
    };
    account.add("probe", streams.iter().map(|stream| escaped(&decoder.probe(stream).name).to_string()));
    account.add("stream", streams.iter().map(|stream| name(stream)));
    let is_known = |name: &str| FootageInfo::has(name) || [SHARD, SHARD_FOOTAGE].contains(&name);
    let attributes = &decoder.reader().index().attributes;
    account.add("attribute", attributes.iter().filter(|(name, _)| is_known(name)).map(|(name, _)| name.to_owned()));
    let is_selected = |one: &StreamInfo| streams.iter().any(|stream| std::ptr::eq(*stream, one));
    let others: Vec<String> = decoder.streams().iter().filter(|one| !is_selected(one)).map(name).collect();
    if !others.is_empty() {
        let names: Vec<&str> = others.iter().map(String::as_str).collect();
        account.left_out.push(format!("streams that were not selected: {}", listed(&names)));
    }
    let unknown = attributes.iter().filter(|(name, _)| !is_known(name));
    account.left_out.extend(
        unknown
            .map(|(name, value)| format!("attribute {name} of {} bytes: this version does not know it", value.len())),
    );
    account
}

//! Account of an input: what a command uses of it, and what it leaves out.

use std::collections::HashSet;

use serde::Serialize;

use codec::error::counted;

/// Maximum number of names in one sentence.
const MAX_LISTED: usize = 12;

/// Joins names for a sentence: the first ones, and the number of the others.
pub fn listed(names: &[&str]) -> String {
    let more = names.len().saturating_sub(MAX_LISTED);
    let more = if more > 0 { format!(" and {more} more") } else { String::new() };
    names[..names.len().min(MAX_LISTED)].join(", ") + &more
}

/// Parts of one kind that are used.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Used {
    /// Kind in the singular, such as `channel`.
    pub kind: &'static str,
    /// Names in the order of the input, each once.
    pub names: Vec<String>,
}

/// The parts of an input that are used, and those that are left out.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize)]
pub struct Account {
    pub used: Vec<Used>,
    /// One sentence for each part that is left out or replaced, with the reason.
    pub left_out: Vec<String>,
}

impl Account {
    /// Adds names of a kind, each once.
    pub fn add(&mut self, kind: &'static str, names: impl IntoIterator<Item = String>) {
        let mut names = names.into_iter().peekable();
        if names.peek().is_none() {
            return;
        }
        let at = self.used.iter().position(|used| used.kind == kind).unwrap_or_else(|| {
            self.used.push(Used { kind, names: Vec::new() });
            self.used.len() - 1
        });
        let all = &mut self.used[at].names;
        let mut known: HashSet<String> = all.iter().cloned().collect();
        all.extend(names.filter(|name| known.insert(name.clone())));
    }

    /// Returns one line with the number of names of each kind, such as `used: 2 file patterns, 4 channels; left out: nothing`.
    pub fn summary(&self) -> String {
        let used: Vec<String> = self.used.iter().map(|used| counted(used.names.len() as u64, used.kind)).collect();
        let used = if used.is_empty() { "nothing".to_owned() } else { used.join(", ") };
        let left_out = match self.left_out.len() {
            0 => "nothing".to_owned(),
            count => count.to_string(),
        };
        format!("used: {used}; left out: {left_out}")
    }

    /// Returns all names and sentences, one line for each kind and each sentence.
    pub fn lines(&self) -> Vec<String> {
        let used = self
            .used
            .iter()
            .map(|Used { kind, names }| format!("used, {}: {}", counted(names.len() as u64, kind), names.join(", ")));
        used.chain(self.left_out.iter().map(|sentence| format!("left out: {sentence}"))).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_counted_once() {
        let mut account = Account::default();
        assert_eq!(account.summary(), "used: nothing; left out: nothing");
        account.add("channel", ["R", "G", "R"].map(str::to_owned));
        account.add("probe", ["00".to_owned()]);
        account.add("channel", ["Z".to_owned()]);
        account.left_out.push("channel A: no alpha is declared".into());
        assert_eq!(account.summary(), "used: 3 channels, 1 probe; left out: 1");
        assert_eq!(
            account.lines(),
            ["used, 3 channels: R, G, Z", "used, 1 probe: 00", "left out: channel A: no alpha is declared"]
        );
    }
}

//! Parser of USD text files: prims with their attributes and time samples. References, payloads and variants are skipped.

use codec::error::{Error, Result};

/// Maximum nesting depth of prims and lists.
const MAX_DEEP: u32 = 64;

#[derive(Debug, Clone, PartialEq)]
pub enum Value {
    Number(f64),
    /// A string, word, path or file name.
    Text(String),
    /// A tuple or an array.
    List(Vec<Value>),
    /// Time samples by increasing time code.
    Samples(Vec<(f64, Value)>),
    /// A dictionary, whose content is skipped.
    Dictionary,
}

#[derive(Debug, Default)]
pub struct Prim {
    /// Type, such as `Camera`; may be empty.
    pub kind: String,
    pub name: String,
    /// True if the specifier is `def`, false for `over` and `class`.
    pub is_defined: bool,
    /// Attributes by name, which includes suffixes such as `.timeSamples` in `xformOp:transform.timeSamples`.
    pub attributes: Vec<(String, Value)>,
    pub children: Vec<Prim>,
}

impl Prim {
    pub fn attribute(&self, name: &str) -> Option<&Value> {
        self.attributes.iter().find(|(other, _)| other == name).map(|(_, value)| value)
    }
}

/// Parses a file to its root prim, whose attributes are the layer metadata.
pub fn parse(text: &str) -> Result<Prim> {
    let mut parser = Parser { text, at: 0 };
    let mut root = Prim::default();
    parser.skip_space();
    if parser.take('(') {
        root.attributes = parser.metadata(0)?;
    }
    parser.body(&mut root, None, 0)?;
    Ok(root)
}

struct Parser<'a> {
    text: &'a str,
    at: usize,
}

impl<'a> Parser<'a> {
    fn rest(&self) -> &'a str {
        self.text.get(self.at..).unwrap_or_default()
    }

    fn fail<T>(&self, expected: &str) -> Result<T> {
        let line = self.text.get(..self.at).unwrap_or_default().matches('\n').count() + 1;
        Err(Error::invalid(format!("line {line}: {expected} was expected")))
    }

    fn skip_space(&mut self) {
        loop {
            let rest = self.rest().trim_start_matches(|c: char| c.is_whitespace() || c == ';');
            self.at = self.text.len() - rest.len();
            if !rest.starts_with('#') {
                return;
            }
            self.at += rest.find('\n').unwrap_or(rest.len());
        }
    }

    /// Consumes a character if it is next.
    fn take(&mut self, wanted: char) -> bool {
        self.skip_space();
        let is_next = self.rest().starts_with(wanted);
        if is_next {
            self.at += wanted.len_utf8();
        }
        is_next
    }

    fn peek(&mut self) -> Option<char> {
        self.skip_space();
        self.rest().chars().next()
    }

    /// Consumes a word, including the `[]` of a type name and all dots and colons.
    fn word(&mut self) -> Option<&'a str> {
        self.skip_space();
        let rest = self.rest();
        let is_part = |c: char| c.is_alphanumeric() || "_:.[]!|".contains(c);
        if !rest.starts_with(|c: char| c.is_alphabetic() || c == '_') {
            return None;
        }
        let end = rest.find(|c: char| !is_part(c)).unwrap_or(rest.len());
        self.at += end;
        Some(&rest[..end])
    }

    /// Consumes text up to a closing mark, and returns the text; the opening mark is already consumed.
    fn until(&mut self, mark: &str) -> Result<&'a str> {
        let rest = self.rest();
        let mut from = 0;
        while let Some(found) = rest[from..].find(mark).map(|found| found + from) {
            let escapes = rest[..found].chars().rev().take_while(|&c| c == '\\').count();
            if escapes % 2 == 0 {
                self.at += found + mark.len();
                return Ok(&rest[..found]);
            }
            from = found + 1;
        }
        self.fail(mark)
    }

    /// Consumes a string, a path or a file name, if it is next.
    fn quoted(&mut self) -> Result<Option<&'a str>> {
        self.skip_space();
        for (open, close) in
            [("\"\"\"", "\"\"\""), ("'''", "'''"), ("\"", "\""), ("'", "'"), ("@@@", "@@@"), ("@", "@"), ("<", ">")]
        {
            if self.rest().starts_with(open) {
                self.at += open.len();
                return self.until(close).map(Some);
            }
        }
        Ok(None)
    }

    fn number(&mut self) -> Option<f64> {
        self.skip_space();
        let rest = self.rest();
        let end = rest.find(|c: char| !(c.is_ascii_alphanumeric() || "+-.".contains(c))).unwrap_or(rest.len());
        let value = rest[..end].parse().ok()?;
        self.at += end;
        Some(value)
    }

    fn value(&mut self, deep: u32) -> Result<Value> {
        if deep > MAX_DEEP {
            return self.fail("less nesting");
        }
        let is_file = self.peek() == Some('@');
        if let Some(text) = self.quoted()? {
            // A file name may be followed by a path in that file and by a time offset.
            if is_file {
                if self.peek() == Some('<') {
                    self.quoted()?;
                }
                if self.take('(') {
                    self.metadata(deep + 1)?;
                }
            }
            return Ok(Value::Text(text.to_owned()));
        }
        match self.peek() {
            Some(open @ ('(' | '[')) => {
                self.at += 1;
                let close = if open == '(' { ')' } else { ']' };
                let mut list = Vec::new();
                while !self.take(close) {
                    list.push(self.value(deep + 1)?);
                    if !self.take(',') && self.peek() != Some(close) {
                        return self.fail("a comma");
                    }
                }
                Ok(Value::List(list))
            }
            Some('{') => {
                self.at += 1;
                self.samples(deep + 1)
            }
            _ => match self.number() {
                Some(number) => Ok(Value::Number(number)),
                None => match self.word() {
                    Some(word) => Ok(Value::Text(word.to_owned())),
                    None => self.fail("a value"),
                },
            },
        }
    }

    /// Parses time samples or a dictionary after the opening brace.
    fn samples(&mut self, deep: u32) -> Result<Value> {
        let mut samples = Vec::new();
        let mut is_dictionary = false;
        while !self.take('}') {
            match self.number() {
                Some(time) if self.take(':') => samples.push((time, self.value(deep + 1)?)),
                Some(_) => return self.fail("a colon"),
                None => {
                    is_dictionary = true;
                    while self.word().is_some() || self.quoted()?.is_some() {}
                    if !self.take('=') && !self.take(':') {
                        return self.fail("an entry");
                    }
                    self.value(deep + 1)?;
                }
            }
            self.take(',');
        }
        if is_dictionary {
            return Ok(Value::Dictionary);
        }
        samples.retain(|(time, _)| time.is_finite());
        samples.sort_by(|a, b| a.0.total_cmp(&b.0));
        Ok(Value::Samples(samples))
    }

    /// Parses metadata entries after the opening parenthesis.
    fn metadata(&mut self, deep: u32) -> Result<Vec<(String, Value)>> {
        if deep > MAX_DEEP {
            return self.fail("less nesting");
        }
        let mut entries = Vec::new();
        while !self.take(')') {
            if self.quoted()?.is_some() {
                continue;
            }
            let mut name = None;
            while let Some(word) = self.word() {
                name = Some(word.to_owned());
            }
            let Some(name) = name else { return self.fail("the name of an entry") };
            if self.take('=') {
                entries.push((name, self.value(deep + 1)?));
            }
        }
        Ok(entries)
    }

    /// Parses the content of a prim up to its closing mark or the end of the file.
    fn body(&mut self, prim: &mut Prim, close: Option<char>, deep: u32) -> Result<()> {
        if deep > MAX_DEEP {
            return self.fail("less nesting");
        }
        loop {
            match (self.peek(), close) {
                (None, None) => return Ok(()),
                (None, Some(close)) => return self.fail(&format!("{close}")),
                (Some(c), Some(close)) if c == close => {
                    self.at += close.len_utf8();
                    return Ok(());
                }
                _ => {}
            }
            let Some(word) = self.word() else { return self.fail("a prim or an attribute") };
            match word {
                "def" | "over" | "class" => {
                    let child = self.prim(word == "def", deep)?;
                    prim.children.push(child);
                }
                "variantSet" => {
                    self.quoted()?;
                    if !(self.take('=') && self.take('{')) {
                        return self.fail("variants");
                    }
                    while !self.take('}') {
                        if self.quoted()?.is_none() {
                            return self.fail("the name of a variant");
                        }
                        self.block(deep)?;
                    }
                }
                first => {
                    // The words of a line: qualifiers, type, name.
                    let mut name = first;
                    loop {
                        let rest = self.rest().trim_start_matches([' ', '\t']);
                        if !rest.starts_with(|c: char| c.is_alphabetic() || c == '_') {
                            break;
                        }
                        name = self.word().unwrap_or(name);
                    }
                    let name = name.to_owned();
                    if self.take('=') {
                        let value = self.value(deep)?;
                        prim.attributes.push((name, value));
                    }
                    if self.take('(') {
                        self.metadata(deep + 1)?;
                    }
                }
            }
        }
    }

    /// Parses a prim after its specifier.
    fn prim(&mut self, is_defined: bool, deep: u32) -> Result<Prim> {
        let kind = self.word().unwrap_or_default().to_owned();
        let Some(name) = self.quoted()?.map(str::to_owned) else { return self.fail("the name of a prim") };
        let mut prim = self.block(deep)?;
        (prim.kind, prim.name, prim.is_defined) = (kind, name, is_defined);
        Ok(prim)
    }

    /// Parses optional metadata and the content of a prim or variant.
    fn block(&mut self, deep: u32) -> Result<Prim> {
        let mut prim = Prim::default();
        if self.take('(') {
            self.metadata(deep + 1)?;
        }
        if !self.take('{') {
            return self.fail("{");
        }
        self.body(&mut prim, Some('}'), deep + 1)?;
        Ok(prim)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prims_have_attributes_and_samples() {
        let text = r#"#usda 1.0
(
    "words about it"
    upAxis = "Z" # the axis
    subLayers = [@a.usda@ (offset = 3; scale = 2), @b.usda@]
)
def Xform "World" (
    prepend references = @other.usda@</X> (offset = 1)
    customData = { string a = "}" }
)
{
    custom rel material:binding = </M>
    float3[] extent = [(0, 1e-3, -inf), (1, 2, 3)] ( doc = "x)" )
    float unset
    double3 xformOp:translate.timeSamples = {
        4: (1, 2, 3),
        -1.5: (0, 0, 0),
    }
    uniform token[] xformOpOrder = ["xformOp:translate", "!invert!xformOp:scale"]
    variantSet "lod" = { "low" { float a = 1 } "high" (doc = "y") { def Camera "hidden" {} } }
    def Camera "one" { float focalLength = 35 }
    over "one" { }
}
"#;
        let root = parse(text).unwrap();
        assert_eq!(root.attribute("upAxis"), Some(&Value::Text("Z".into())));
        let world = &root.children[0];
        assert_eq!((world.kind.as_str(), world.name.as_str(), world.is_defined), ("Xform", "World", true));
        let Some(Value::Samples(samples)) = world.attribute("xformOp:translate.timeSamples") else {
            panic!("{world:?}")
        };
        assert_eq!(samples.iter().map(|(time, _)| *time).collect::<Vec<_>>(), [-1.5, 4.0]);
        let order = ["xformOp:translate", "!invert!xformOp:scale"].map(|op| Value::Text(op.into()));
        assert_eq!(world.attribute("xformOpOrder"), Some(&Value::List(order.to_vec())));
        assert_eq!(world.attribute("unset"), None);
        assert_eq!(world.children.len(), 2);
        assert_eq!(world.children[0].attribute("focalLength"), Some(&Value::Number(35.0)));
        assert!(!world.children[1].is_defined);
    }

    #[test]
    fn text_that_is_none_is_refused_by_its_line() {
        for (text, words) in [
            ("#usda 1.0\ndef Camera", "line 2: the name of a prim"),
            ("def \"a\" {", "line 1: } was expected"),
            ("def \"a\" { float b = }", "a value"),
            ("def \"a\" { float b = (1 2) }", "a comma"),
            ("def \"a {", "\" was expected"),
            ("(upAxis = \"Y\"\n", "line 2"),
        ] {
            let said = parse(text).unwrap_err().to_string();
            assert!(said.contains(words), "{text}: {said}");
        }
        assert!(parse(&"def \"a\" {".repeat(1000)).unwrap_err().to_string().contains("nesting"));
        assert!(
            parse(&format!("def \"a\" {{ int b = {}", "[".repeat(1000))).unwrap_err().to_string().contains("nesting")
        );
    }
}

//! From text to nodes: operators by how strongly they bind.

use thiserror::Error;

use super::{Expression, Function, Node, Operation, Relation, RelationKind};

/// How deep brackets may be nested.
const DEPTH_MAX: usize = 200;

/// A formula that cannot be read.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("formula `{text}`, letter {at}\n  expected: {expected}\n  found:    {found}\n  next:     {next}")]
pub struct ParseError {
    /// The formula.
    pub text: String,
    /// Which letter, from 1.
    pub at: usize,
    /// What belongs there.
    pub expected: String,
    /// What stands there.
    pub found: String,
    /// What to do.
    pub next: String,
}

#[derive(Debug, Clone, PartialEq)]
enum Token {
    Number(f64),
    Name(String),
    Plus,
    Minus,
    Times,
    Over,
    Power,
    Open(char),
    Close(char),
    Comma,
    Relation(RelationKind),
    End,
}

/// A formula, all of the text.
pub fn whole(text: &str) -> Result<Expression, ParseError> {
    let mut parser = Parser::new(text)?;
    let (nodes, symbols) = parser.side()?;
    parser.end("an operator or the end")?;
    Ok(Expression { nodes, symbols, text: text.trim().to_owned() })
}

/// Two formulas and what is said of them.
pub fn relation(text: &str) -> Result<Relation, ParseError> {
    let mut parser = Parser::new(text)?;
    let (nodes, symbols) = parser.side()?;
    let Token::Relation(kind) = *parser.token() else {
        return Err(parser.wrong("one of =, <, <=, >, >=", "say what the left side is compared with"));
    };
    let middle = parser.place();
    parser.next();
    let left = Expression { nodes, symbols, text: slice(text, 0, middle) };
    let start = parser.place();
    let (nodes, symbols) = parser.side()?;
    parser.end("an operator or the end; a relation has two sides")?;
    let right = Expression { nodes, symbols, text: slice(text, start, usize::MAX) };
    Ok(Relation { left, kind, right })
}

/// Letters of a text, without spaces at the ends.
fn slice(text: &str, from: usize, to: usize) -> String {
    let letters: String = text.chars().skip(from).take(to.saturating_sub(from)).collect();
    letters.trim().to_owned()
}

struct Parser<'a> {
    text: &'a str,
    tokens: Vec<(usize, Token)>,
    at: usize,
    nodes: Vec<Node>,
    symbols: Vec<String>,
}

impl<'a> Parser<'a> {
    fn new(text: &'a str) -> Result<Self, ParseError> {
        Ok(Self { text, tokens: tokens(text)?, at: 0, nodes: vec![], symbols: vec![] })
    }

    fn token(&self) -> &Token {
        &self.tokens[self.at].1
    }

    fn place(&self) -> usize {
        self.tokens[self.at].0
    }

    /// The last token is the end, which is never passed.
    fn next(&mut self) {
        self.at = (self.at + 1).min(self.tokens.len() - 1);
    }

    /// A whole formula, ending where no operator follows.
    fn side(&mut self) -> Result<(Vec<Node>, Vec<String>), ParseError> {
        self.nodes.clear();
        self.symbols.clear();
        self.sum(0)?;
        Ok((std::mem::take(&mut self.nodes), std::mem::take(&mut self.symbols)))
    }

    fn end(&self, expected: &str) -> Result<(), ParseError> {
        if *self.token() == Token::End {
            Ok(())
        } else {
            Err(self.wrong(expected, "write an operator between the two"))
        }
    }

    fn push(&mut self, node: Node) -> usize {
        self.nodes.push(node);
        self.nodes.len() - 1
    }

    fn sum(&mut self, depth: usize) -> Result<usize, ParseError> {
        let mut left = self.product(depth)?;
        loop {
            let operation = match self.token() {
                Token::Plus => Operation::Add,
                Token::Minus => Operation::Subtract,
                _ => return Ok(left),
            };
            self.next();
            let right = self.product(depth)?;
            left = self.push(Node::Apply(operation, vec![left, right]));
        }
    }

    fn product(&mut self, depth: usize) -> Result<usize, ParseError> {
        let mut left = self.signed(depth)?;
        loop {
            let operation = match self.token() {
                Token::Times => Operation::Multiply,
                Token::Over => Operation::Divide,
                _ => return Ok(left),
            };
            self.next();
            let right = self.signed(depth)?;
            left = self.push(Node::Apply(operation, vec![left, right]));
        }
    }

    fn signed(&mut self, depth: usize) -> Result<usize, ParseError> {
        if depth > DEPTH_MAX {
            return Err(self.wrong("brackets nested less deeply", "name intermediate values"));
        }
        match self.token() {
            Token::Minus => {
                self.next();
                let inner = self.signed(depth + 1)?;
                Ok(self.push(Node::Apply(Operation::Negate, vec![inner])))
            }
            Token::Plus => {
                self.next();
                self.signed(depth + 1)
            }
            _ => {
                let base = self.atom(depth)?;
                if *self.token() != Token::Power {
                    return Ok(base);
                }
                self.next();
                let power = self.signed(depth + 1)?;
                Ok(self.push(Node::Apply(Operation::Power, vec![base, power])))
            }
        }
    }

    fn atom(&mut self, depth: usize) -> Result<usize, ParseError> {
        match self.token().clone() {
            Token::Number(value) => {
                self.next();
                Ok(self.push(Node::Constant(value)))
            }
            Token::Open(open) => {
                self.next();
                let inner = self.sum(depth + 1)?;
                self.close(open)?;
                Ok(inner)
            }
            Token::Name(name) => {
                let place = self.at;
                self.next();
                if let Token::Open(open) = *self.token() {
                    return self.call(&name, place, open, depth);
                }
                if name == "pi" {
                    return Ok(self.push(Node::Constant(std::f64::consts::PI)));
                }
                if Function::find(&name).is_some() {
                    return Err(self.wrong("a bracket after the name of a function", "write its argument in brackets"));
                }
                let known = self.symbols.iter().position(|symbol| *symbol == name);
                let i = known.unwrap_or_else(|| {
                    self.symbols.push(name);
                    self.symbols.len() - 1
                });
                Ok(self.push(Node::Symbol(i)))
            }
            _ => Err(self.wrong("a number, a name or a bracket", "complete the formula")),
        }
    }

    fn call(&mut self, name: &str, place: usize, open: char, depth: usize) -> Result<usize, ParseError> {
        let Some(function) = Function::find(name) else {
            self.at = place;
            return Err(self.wrong(
                "a function: exp, ln, log10, sqrt, abs, sin, cos, tan, asin, acos, atan, sinh, cosh, tanh, min, max, mean, sum, rms, count",
                "for a product write `*`",
            ));
        };
        self.next();
        let mut arguments = vec![self.sum(depth + 1)?];
        while *self.token() == Token::Comma && matches!(function, Function::Min | Function::Max) {
            self.next();
            arguments.push(self.sum(depth + 1)?);
        }
        self.close(open)?;
        Ok(self.push(Node::Apply(Operation::Call(function), arguments)))
    }

    fn close(&mut self, open: char) -> Result<(), ParseError> {
        let close = if open == '(' { ')' } else { ']' };
        if *self.token() == Token::Close(close) {
            self.next();
            return Ok(());
        }
        Err(self.wrong(&format!("an operator or `{close}`"), "close the bracket"))
    }

    fn wrong(&self, expected: &str, next: &str) -> ParseError {
        let at = self.place();
        let rest: String = self.text.chars().skip(at).take(12).collect();
        let found = if rest.is_empty() { "the end".to_owned() } else { format!("`{rest}`") };
        error(self.text, at, expected, found, next)
    }
}

fn error(text: &str, at: usize, expected: &str, found: String, next: &str) -> ParseError {
    const LETTERS_MAX: usize = 160;
    let mut shown: String = text.chars().take(LETTERS_MAX).collect();
    if text.chars().count() > LETTERS_MAX {
        shown.push('…');
    }
    ParseError { text: shown, at: at + 1, expected: expected.to_owned(), found, next: next.to_owned() }
}

fn tokens(text: &str) -> Result<Vec<(usize, Token)>, ParseError> {
    let letters: Vec<char> = text.chars().collect();
    let mut tokens = Vec::new();
    let mut at = 0;
    while let Some(&letter) = letters.get(at) {
        let start = at;
        at += 1;
        let following = letters.get(at).copied();
        let token = match letter {
            _ if letter.is_whitespace() => continue,
            '+' => Token::Plus,
            '-' | '−' => Token::Minus,
            '*' if following == Some('*') => {
                at += 1;
                Token::Power
            }
            '*' | '×' | '·' => Token::Times,
            '/' => Token::Over,
            '^' => Token::Power,
            '(' | '[' => Token::Open(letter),
            ')' | ']' => Token::Close(letter),
            ',' => Token::Comma,
            '=' => {
                at += usize::from(following == Some('='));
                Token::Relation(RelationKind::Equal)
            }
            '<' | '>' => {
                let or_equal = following == Some('=');
                at += usize::from(or_equal);
                Token::Relation(match (letter, or_equal) {
                    ('<', false) => RelationKind::Less,
                    ('<', true) => RelationKind::LessOrEqual,
                    (_, false) => RelationKind::Greater,
                    (_, true) => RelationKind::GreaterOrEqual,
                })
            }
            '0'..='9' | '.' => {
                at = end_of_number(&letters, start);
                let word: String = letters[start..at].iter().collect();
                match word.parse::<f64>() {
                    Ok(value) if value.is_finite() => Token::Number(value),
                    _ => return Err(error(text, start, "a number", format!("`{word}`"), "correct it")),
                }
            }
            _ if letter.is_alphabetic() || letter == '_' => {
                while letters.get(at).is_some_and(|l| l.is_alphanumeric() || *l == '_') {
                    at += 1;
                }
                Token::Name(letters[start..at].iter().collect())
            }
            _ => {
                let found = format!("`{letter}`");
                return Err(error(text, start, "a number, a name, an operator or a bracket", found, "remove it"));
            }
        };
        tokens.push((start, token));
    }
    tokens.push((letters.len(), Token::End));
    Ok(tokens)
}

/// Where a number that starts somewhere ends: digits, a point, an exponent with its sign.
fn end_of_number(letters: &[char], start: usize) -> usize {
    let digit = |at: usize| letters.get(at).is_some_and(char::is_ascii_digit);
    let mut at = start;
    while digit(at) || letters.get(at) == Some(&'.') {
        at += 1;
    }
    if matches!(letters.get(at), Some('e' | 'E')) {
        let sign = usize::from(matches!(letters.get(at + 1), Some('+' | '-')));
        if digit(at + 1 + sign) {
            at += 1 + sign;
            while digit(at) {
                at += 1;
            }
        }
    }
    at
}

//! Messages as Protobuf: every number an optional double, stamps as `google.protobuf.Timestamp`.

use prost::Message as _;
use prost_types::field_descriptor_proto::{Label, Type};
use prost_types::{DescriptorProto, FieldDescriptorProto, FileDescriptorProto, FileDescriptorSet, Timestamp};

use super::{Node, Source};
use crate::formats::mcap::HEADER_STAMPS;

/// The descriptors that a file with such messages holds.
pub(super) fn descriptors(name: &str, nodes: &[Node]) -> Vec<u8> {
    let time = DescriptorProto {
        name: Some("Timestamp".to_owned()),
        field: vec![field("seconds", 1, Type::Int64, None), field("nanos", 2, Type::Int32, None)],
        ..DescriptorProto::default()
    };
    let google = FileDescriptorProto {
        name: Some("google/protobuf/timestamp.proto".to_owned()),
        package: Some("google.protobuf".to_owned()),
        message_type: vec![time],
        syntax: Some("proto3".to_owned()),
        ..FileDescriptorProto::default()
    };
    // The older syntax tells an absent number from 0 without further ado.
    let own = FileDescriptorProto {
        name: Some("pneuval.proto".to_owned()),
        dependency: vec!["google/protobuf/timestamp.proto".to_owned()],
        message_type: vec![message(name, &format!(".{name}"), nodes)],
        syntax: Some("proto2".to_owned()),
        ..FileDescriptorProto::default()
    };
    FileDescriptorSet { file: vec![google, own] }.encode_to_vec()
}

fn field(name: &str, number: i32, kind: Type, of: Option<String>) -> FieldDescriptorProto {
    FieldDescriptorProto {
        name: Some(name.to_owned()),
        number: Some(number),
        label: Some(Label::Optional.into()),
        r#type: Some(kind.into()),
        type_name: of,
        ..FieldDescriptorProto::default()
    }
}

fn is_stamp(node: &Node) -> bool {
    HEADER_STAMPS.contains(&node.path.as_str())
}

fn message(name: &str, full: &str, nodes: &[Node]) -> DescriptorProto {
    let mut out = DescriptorProto { name: Some(name.to_owned()), ..DescriptorProto::default() };
    for (number, node) in (1..).zip(nodes) {
        let field = if !node.below.is_empty() {
            let inside = format!("T{}", node.name);
            let full = format!("{full}.{inside}");
            out.nested_type.push(message(&inside, &full, &node.below));
            field(&node.name, number, Type::Message, Some(full))
        } else if is_stamp(node) {
            field(&node.name, number, Type::Message, Some(".google.protobuf.Timestamp".to_owned()))
        } else {
            field(&node.name, number, if node.text { Type::String } else { Type::Double }, None)
        };
        out.field.push(field);
    }
    out
}

/// A message; a hole is an absent field.
pub(super) fn encode(nodes: &[Node], source: &Source, row: usize, out: &mut Vec<u8>) {
    for (number, node) in (1_u64..).zip(nodes) {
        if !node.below.is_empty() {
            let mut inside = vec![];
            encode(&node.below, source, row, &mut inside);
            counted(number, &inside, out);
        } else if node.text {
            counted(number, source.text(&node.path, row).as_bytes(), out);
        } else if is_stamp(node) {
            let Some(ns) = source.ns(&node.path, row) else { continue };
            // Seconds and nanoseconds of a u64 of nanoseconds fit.
            let time = Timestamp {
                seconds: (ns / 1_000_000_000).cast_signed(),
                nanos: i32::try_from(ns % 1_000_000_000).unwrap_or(0),
            };
            counted(number, &time.encode_to_vec(), out);
        } else if let Some(value) = source.number(&node.path, row).filter(|value| !value.is_nan()) {
            prost::encoding::encode_varint(number << 3 | 1, out);
            out.extend_from_slice(&value.to_le_bytes());
        }
    }
}

/// Bytes after their field number and length.
fn counted(number: u64, bytes: &[u8], out: &mut Vec<u8>) {
    prost::encoding::encode_varint(number << 3 | 2, out);
    prost::encoding::encode_varint(bytes.len() as u64, out);
    out.extend_from_slice(bytes);
}

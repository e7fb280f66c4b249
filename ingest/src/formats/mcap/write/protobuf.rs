//! Messages as Protobuf: every number an optional double, stamps as `google.protobuf.Timestamp`.

use prost_reflect::prost::Message as _;
use prost_reflect::prost_types::field_descriptor_proto::{Label, Type};
use prost_reflect::prost_types::{DescriptorProto, FieldDescriptorProto, FileDescriptorProto, FileDescriptorSet};
use prost_reflect::{DescriptorPool, DynamicMessage, MessageDescriptor, Value};

use super::{Node, Source};
use crate::formats::mcap::HEADER_STAMPS;

const TIMESTAMP: &str = "google.protobuf.Timestamp";

/// The descriptors that a file with such messages holds, and that of the messages.
pub(super) fn descriptor(name: &str, nodes: &[Node]) -> Result<(Vec<u8>, MessageDescriptor), String> {
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
    let set = FileDescriptorSet { file: vec![google, own] }.encode_to_vec();
    let pool = DescriptorPool::decode(set.as_slice()).map_err(|error| error.to_string())?;
    let found = pool.get_message_by_name(name).ok_or_else(|| format!("no message {name}"))?;
    Ok((set, found))
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
            field(&node.name, number, Type::Message, Some(format!(".{TIMESTAMP}")))
        } else {
            field(&node.name, number, if node.text { Type::String } else { Type::Double }, None)
        };
        out.field.push(field);
    }
    out
}

/// A message; a hole is an absent field.
pub(super) fn encode(
    descriptor: &MessageDescriptor,
    nodes: &[Node],
    source: &Source,
    row: usize,
    out: &mut Vec<u8>,
) -> Result<(), String> {
    filled(descriptor, nodes, source, row)?.encode(out).map_err(|error| error.to_string())
}

fn filled(of: &MessageDescriptor, nodes: &[Node], source: &Source, row: usize) -> Result<DynamicMessage, String> {
    let mut message = DynamicMessage::new(of.clone());
    for (number, node) in (1..).zip(nodes) {
        let kind = of.get_field(number).and_then(|field| field.kind().as_message().cloned());
        let value = match kind {
            Some(kind) if !node.below.is_empty() => Value::Message(filled(&kind, &node.below, source, row)?),
            Some(kind) => {
                let Some(ns) = source.ns(&node.path, row) else { continue };
                let mut time = DynamicMessage::new(kind);
                // Seconds and nanoseconds of a u64 of nanoseconds fit.
                time.set_field_by_number(1, Value::I64((ns / 1_000_000_000).cast_signed()));
                time.set_field_by_number(2, Value::I32((ns % 1_000_000_000) as i32));
                Value::Message(time)
            }
            None if node.text => Value::String(source.text(&node.path, row).to_owned()),
            None => match source.number(&node.path, row) {
                Some(number) if !number.is_nan() => Value::F64(number),
                _ => continue,
            },
        };
        message.try_set_field_by_number(number, value).map_err(|error| error.to_string())?;
    }
    Ok(message)
}

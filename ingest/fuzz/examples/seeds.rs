//! Writes the seeds that are no text: `cargo run --example seeds`, in `ingest/fuzz`.
//!
//! Chunks are also written without their checksum (0 stands for none), so that a mutated byte in them reaches what decodes it.

#[path = "../../tests/common/tdms.rs"]
mod build;

use std::error::Error;
use std::fs;
use std::io::Cursor;
use std::path::Path;

use pneuval_ingest::finding::LineMap;
use pneuval_ingest::formats::csv::Decimal;
use pneuval_ingest::formats::mcap::{Compression, Encoding, WriteOptions, write};
use pneuval_ingest::recording::{Cells, Column, Table};
use pneuval_ingest_fuzz::{FILE, MESSAGE};

const ROWS: usize = 4;

const KINDS: &str = "bool b\nint8 i8\nuint16 u16\nfloat32 f32\nfloat64[2] pair\nstring word\nrig_msgs/Inner inner\n\
================================================================================\nMSG: rig_msgs/Inner\nint16 a\nfloat64 x\n";

const EVERYTHING: &str = "int8 C=5\nbool b\nuint16 u\nint64 i\nfloat64 f\nstring<=9 word\nwstring wide\npkg/In in\nfloat32[2] pair\n\
int16[] some\npkg/In[<=4] more\nstring[] words\nbuiltin_interfaces/Time stamp\n===\nMSG: pkg/In\nint16 a\nfloat64 x\n\
===\nMSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n";

fn table(name: &str, schema: &str, columns: &[&str]) -> Table {
    let numbers = |index: usize| (0..ROWS).map(|row| (row * (index + 1)) as f64).collect();
    let column = |(index, name): (usize, &&str)| match *name {
        "word" => Column::new(name, None, Cells::Text(vec!["on".to_owned(); ROWS])),
        "log_time" => Column::new(name, Some("s"), Cells::Numbers((0..ROWS).map(|row| row as f64 / 100.0).collect())),
        _ => Column::new(name, None, Cells::Numbers(numbers(index))),
    };
    Table {
        name: name.to_owned(),
        schema: Some(schema.to_owned()),
        columns: columns.iter().enumerate().map(column).collect(),
        rows: ROWS,
        lines: LineMap::default(),
        clock: None,
        decimal: Decimal::Point,
    }
}

fn bag(encoding: Encoding, compression: Compression, is_small: bool) -> Result<Vec<u8>, Box<dyn Error>> {
    let pressure = table(
        "/p",
        "sensor_msgs/msg/FluidPressure",
        &["log_time", "publish_time", "header.stamp", "fluid_pressure", "variance"],
    );
    let kinds = table(
        "/k",
        "rig_msgs/msg/Kinds",
        &["log_time", "b", "i8", "u16", "f32", "pair[0]", "pair[1]", "word", "inner.a", "inner.x"],
    );
    let options = WriteOptions {
        encoding,
        compression,
        chunk_bytes: Some(400),
        origin_s: 1_700_000_000,
        definitions: vec![("rig_msgs/msg/Kinds".to_owned(), KINDS.to_owned())],
        metadata: vec![],
    };
    let mut out = Cursor::new(vec![]);
    let tables = if is_small { vec![pressure] } else { vec![pressure, kinds] };
    write(&mut out, &tables, &options)?;
    Ok(out.into_inner())
}

/// The same file with no checksum in its chunks; it ends with its data, which is half as long.
fn without_checksums(mut file: Vec<u8>) -> Vec<u8> {
    let mut at = 8;
    while let Some(length) = file.get(at + 1..at + 9).and_then(|bytes| bytes.try_into().ok()) {
        let body = at + 9;
        match file[at] {
            6 => file[body + 24..body + 28].fill(0),
            15 => {
                file.truncate(at);
                // End of data, an empty footer, and the magic again.
                file.extend([15, 4, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 2, 20, 0, 0, 0, 0, 0, 0, 0]);
                file.extend([0; 20]);
                file.extend(b"\x89MCAP0\r\n");
                break;
            }
            _ => {}
        }
        at = body + u64::from_le_bytes(length) as usize;
    }
    file
}

fn save(target: &str, name: &str, bytes: &[u8]) -> std::io::Result<()> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("seeds").join(target);
    fs::create_dir_all(&folder)?;
    fs::write(folder.join(name), bytes)
}

/// TDMS files of few bytes, each with something of its own.
fn tdms() -> std::io::Result<()> {
    use build::*;
    save("tdms", "segments.tdms", &two_channels())?;
    for (name, order) in [("little", LITTLE), ("big", BIG)] {
        let of = |code: u32, width: usize| {
            let object = order.object("/'g'/'x'", &order.index(code, 2), &[("unit_string", Prop::Text("kPa"))]);
            let other = order.object("/'g'/'y'", &order.index(code, 2), &[("wf_increment", Prop::F64(0.01))]);
            order.segment(USUAL | INTERLEAVED, &[object, other], &vec![1; 4 * width])
        };
        for (code, width) in [(1, 1), (2, 2), (3, 4), (4, 8), (9, 4), (10, 8), (0x21, 1), (0x44, 16), (0x0008_000c, 8)]
        {
            save("tdms", &format!("{name}-{code:x}.tdms"), &of(code, width))?;
        }
        let texts = [order.u32(2), order.u32(2), order.u32(4), b"onof".to_vec()].concat();
        let object = order.object("/'g'/'s'", &order.text_index(3, texts.len() as u64), &[]);
        save("tdms", &format!("{name}-text.tdms"), &order.segment(USUAL, &[object], &[texts.clone(), texts].concat()))?;
        let lines = [0, 9].map(|line| {
            order.object(&format!("/'d'/'{line}'"), &order.daqmx(7, true, 2, &[(4, 0, line, 0)], &[4]), &[])
        });
        save("tdms", &format!("{name}-lines.tdms"), &order.segment(USUAL | DAQMX, &lines, &[3; 16]))?;
    }
    let scale = |kind: &'static str, own: &[(&'static str, Prop<'static>)]| {
        let mut props = vec![("NI_Number_Of_Scales", Prop::U32(2)), ("NI_Scale[1]_Scale_Type", Prop::Text(kind))];
        props.extend(own);
        let index = LITTLE.daqmx(u32::MAX, false, 4, &[(3, 0, 0, 0), (3, 1, 0, 1)], &[2, 2]);
        LITTLE.segment(USUAL | DAQMX, &[LITTLE.object(P, &index, &props)], &i16s(&[1, 2, 3, 4, 5, 6, 7, 8]))
    };
    let linear = [
        ("NI_Scale[1]_Linear_Slope", Prop::F64(0.5)),
        ("NI_Scale[1]_Linear_Y_Intercept", Prop::F64(10.0)),
        ("NI_Scale[1]_Linear_Input_Source", Prop::U32(0)),
    ];
    save("tdms", "linear.tdms", &scale("Linear", &linear))?;
    let polynomial = [
        ("NI_Scale[1]_Polynomial_Coefficients_Size", Prop::U32(2)),
        ("NI_Scale[1]_Polynomial_Coefficients[0]", Prop::F64(1.0)),
        ("NI_Scale[1]_Polynomial_Coefficients[1]", Prop::F64(2.0)),
        ("NI_Scale[1]_Polynomial_Input_Source", Prop::U32(0)),
    ];
    save("tdms", "polynomial.tdms", &scale("Polynomial", &polynomial))?;
    let table = [
        ("NI_Scale[1]_Table_Pre_Scaled_Values_Size", Prop::U32(2)),
        ("NI_Scale[1]_Table_Scaled_Values_Size", Prop::U32(2)),
        ("NI_Scale[1]_Table_Pre_Scaled_Values[0]", Prop::F64(0.0)),
        ("NI_Scale[1]_Table_Pre_Scaled_Values[1]", Prop::F64(8.0)),
        ("NI_Scale[1]_Table_Scaled_Values[0]", Prop::F64(0.0)),
        ("NI_Scale[1]_Table_Scaled_Values[1]", Prop::F64(1.0)),
        ("NI_Scale[1]_Table_Input_Source", Prop::U32(0)),
    ];
    save("tdms", "table.tdms", &scale("Table", &table))?;
    let add = [
        ("NI_Scale[1]_Add_Left_Operand_Input_Source", Prop::U32(0)),
        ("NI_Scale[1]_Add_Right_Operand_Input_Source", Prop::U32(0)),
    ];
    save("tdms", "add.tdms", &scale("Add", &add))
}

fn main() -> Result<(), Box<dyn Error>> {
    tdms()?;
    let compressions = [("none", Compression::None), ("lz4", Compression::Lz4), ("zstd", Compression::Zstd)];
    for (encoding_name, encoding) in
        [("cdr", Encoding::Cdr), ("json", Encoding::Json), ("protobuf", Encoding::Protobuf)]
    {
        for (compression_name, compression) in compressions {
            let name = format!("{encoding_name}-{compression_name}.mcap");
            save("mcap", &name, &without_checksums(bag(encoding, compression, false)?))?;
        }
    }
    save("mcap", "whole.mcap", &bag(Encoding::Cdr, Compression::None, true)?)?;

    let part = without_checksums(bag(Encoding::Cdr, Compression::None, true)?);
    let yaml = "rosbag2_bagfile_information:\n  version: 6\n  storage_identifier: mcap\n  relative_file_paths:\n    - r_1.mcap\n    \
                - r_0.mcap\n  message_count: 8\n  topics_with_message_count:\n    - topic_metadata:\n        name: /p\n      \
                message_count: 8\n  compression_mode: \"\"\n";
    let files = |files: &[(&str, &[u8])]| {
        let each = files.iter().map(|(name, bytes)| [name.as_bytes(), b"\n", bytes].concat());
        each.collect::<Vec<_>>().join(FILE)
    };
    let metadata = ("metadata.yaml", yaml.as_bytes());
    save("bag", "split", &files(&[metadata, ("r_0.mcap", &part), ("r_1.mcap", &part)]))?;
    save("bag", "bare", &files(&[("r_0.mcap", &part), ("notes.txt", b"x")]))?;
    save("bag", "metadata", &files(&[metadata, ("r_0.mcap", b"")]))?;
    save("bag", "db3", &files(&[metadata, ("r_0.db3", b"SQLite format 3\0")]))?;

    let messages = |kind: u8, parts: &[&[u8]]| [&[kind][..], &parts.join(MESSAGE)].concat();
    let mut body = vec![0, 1, 0, 0, 1, 0xee, 16, 0, 0, 0, 0, 0, 7, 0, 0, 0, 0, 0, 0, 0];
    body.extend(1.5_f64.to_le_bytes());
    body.extend([3, 0, 0, 0, b'o', b'n', 0, 0, 1, 0, 0, 0, b'w', 0, 0, 0, 7, 0]);
    body.resize(4 + 48, 0);
    body.extend(2.5_f64.to_le_bytes());
    body.extend([0; 8]);
    body.extend([2, 0, 0, 0, 1, 0, 2, 0, 1, 0, 0, 0, 5, 0, 0, 0]);
    body.extend(3.5_f64.to_le_bytes());
    body.extend([1, 0, 0, 0, 2, 0, 0, 0, b'x', 0, 0, 0]);
    body.extend([0; 8]);
    save("messages", "everything", &messages(b'c', &[EVERYTHING.as_bytes(), &body, &body[..40]]))?;
    let number = [&[0, 1, 0, 0][..], &1.5_f64.to_le_bytes()].concat();
    save("messages", "number", &messages(b'c', &[b"float64 x", &number, &number]))?;
    let sequence = [0, 0, 0, 0, 0, 0, 0, 2, 0, 1, 0, 2];
    save("messages", "sequence", &messages(b'c', &[b"int16[] x\n", &sequence, &sequence[..8]]))?;
    let json =
        br#"{"header":{"stamp":{"sec":17,"nanosec":5}},"p":{"v":1.5e3,"ok":true},"a":[1,[2,null]],"who":"x\u00e9"}"#;
    save("messages", "json", &messages(b'j', &[b"{}", json, br#"{"p":{"v":"nan"}}"#, b"[1]"]))?;
    // A set of one file: `message T { double x = 1; repeated int32 n = 2; T t = 3; string s = 4; }` of package `pkg`.
    let field = |name: u8, number: u8, label: u8, kind: u8, rest: &[u8]| {
        let body = [&[10, 1, name, 24, number, 32, label, 40, kind][..], rest].concat();
        [&[18, body.len() as u8][..], &body].concat()
    };
    let fields = [
        field(b'x', 1, 1, 1, b""),
        field(b'n', 2, 3, 5, b""),
        field(b't', 3, 1, 11, b"\x32\x06.pkg.T"),
        field(b's', 4, 1, 9, b""),
    ];
    let message = [&b"\x0a\x01T"[..], &fields.concat()].concat();
    let head = b"\x0a\x03a.p\x12\x03pkg".to_vec();
    let file = [&head[..], &[34, message.len() as u8], &message, b"\x62\x06proto3"].concat();
    let set = [&[10, file.len() as u8][..], &file].concat();
    let sent = [&[9][..], &1.5_f64.to_le_bytes(), &[18, 2, 1, 2, 26, 4, 16, 7, 16, 8, 34, 2, b'o', b'n']].concat();
    save("messages", "protobuf", &messages(b'p', &[&set, &sent, &sent[..9]]))?;
    Ok(())
}

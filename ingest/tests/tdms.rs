//! TDMS: every type, every way in which values can stand, scalings, times, and damage.

// In a test a panic is how a failure is told; equality of floats is asked where it must be exact.
#![allow(clippy::unwrap_used, clippy::panic, clippy::float_cmp)]

#[path = "common/tdms.rs"]
mod build;

use build::*;
use pneuval_ingest::IngestError;
use pneuval_ingest::finding::{Finding, FindingKind, Severity};
use pneuval_ingest::formats::tdms::read;
use pneuval_ingest::formats::{Format, detect};
use pneuval_ingest::raw::RawFile;
use pneuval_ingest::recording::{Cells, ColumnRef, Keep, Recording, Table};

fn file(bytes: &[u8]) -> Recording {
    read(&RawFile::of_bytes("r.tdms", bytes), Keep::All).unwrap()
}

fn error(bytes: &[u8]) -> String {
    match read(&RawFile::of_bytes("r.tdms", bytes), Keep::All) {
        Err(error @ IngestError::Unusable { .. }) => error.to_string(),
        Err(other) => panic!("another error: {other}"),
        Ok(recording) => panic!("read: {recording:?}"),
    }
}

fn column<'r>(recording: &'r Recording, name: &str) -> &'r [f64] {
    let of = |table: &'r Table| table.columns.iter().find(|c| table.full_name(&c.name) == name);
    let column = recording.tables.iter().find_map(of).unwrap_or_else(|| panic!("no column {name}"));
    column.cells.numbers().unwrap_or_else(|| panic!("{name} is not kept"))
}

fn text<'r>(recording: &'r Recording, name: &str) -> &'r [String] {
    recording.tables.iter().find_map(|table| table.column(name)).unwrap().cells.text().unwrap()
}

fn names(recording: &Recording) -> Vec<Vec<String>> {
    recording.tables.iter().map(|t| t.columns.iter().map(|c| t.full_name(&c.name)).collect()).collect()
}

fn told(findings: &[Finding]) -> Vec<(FindingKind, Severity)> {
    findings.iter().map(|f| (f.kind, f.severity)).collect()
}

const CUT: (FindingKind, Severity) = (FindingKind::Truncated, Severity::Lost);

#[test]
fn every_type_of_number_in_both_orders_and_both_layouts() {
    let values: [(u32, Vec<Vec<u8>>, [f64; 2]); 11] = [
        (1, vec![vec![0x80], vec![0x7f]], [-128.0, 127.0]),
        (2, vec![i16::MIN.to_le_bytes().to_vec(), 258_i16.to_le_bytes().to_vec()], [-32768.0, 258.0]),
        (3, vec![i32::MIN.to_le_bytes().to_vec(), 66_051_i32.to_le_bytes().to_vec()], [-2_147_483_648.0, 66_051.0]),
        (4, vec![i64::MIN.to_le_bytes().to_vec(), 5_i64.to_le_bytes().to_vec()], [-2.0_f64.powi(63), 5.0]),
        (5, vec![vec![255], vec![1]], [255.0, 1.0]),
        (6, vec![u16::MAX.to_le_bytes().to_vec(), 258_u16.to_le_bytes().to_vec()], [65535.0, 258.0]),
        (7, vec![u32::MAX.to_le_bytes().to_vec(), 1_u32.to_le_bytes().to_vec()], [4_294_967_295.0, 1.0]),
        // The nearest double of 2^64 - 1 is 2^64.
        (8, vec![u64::MAX.to_le_bytes().to_vec(), 1_u64.to_le_bytes().to_vec()], [2.0_f64.powi(64), 1.0]),
        (9, vec![0.1_f32.to_le_bytes().to_vec(), (-2.5_f32).to_le_bytes().to_vec()], [f64::from(0.1_f32), -2.5]),
        (0x1a, vec![0.1_f64.to_le_bytes().to_vec(), (-2.5_f64).to_le_bytes().to_vec()], [0.1, -2.5]),
        (0x21, vec![vec![0], vec![2]], [0.0, 1.0]),
    ];
    for order in [LITTLE, BIG] {
        let objects: Vec<Vec<u8>> = values
            .iter()
            .enumerate()
            .map(|(i, (code, ..))| order.object(&format!("/'g'/'{i}'"), &order.index(*code, 2), &[]))
            .collect();
        let both = |i: usize| values.iter().map(move |(_, bytes, _)| order.bytes(&bytes[i])).collect::<Vec<_>>();
        let contiguous: Vec<u8> = both(0).into_iter().zip(both(1)).flat_map(|(a, b)| [a, b].concat()).collect();
        let interleaved: Vec<u8> = [both(0).concat(), both(1).concat()].concat();
        for (toc, data) in [(USUAL, contiguous), (USUAL | INTERLEAVED, interleaved)] {
            let recording = file(&order.segment(toc, &objects, &data));
            // Two of them hold integers that no double holds.
            assert_eq!(told(&recording.findings), [(FindingKind::Rounded, Severity::Note); 2]);
            for (i, (.., expected)) in values.iter().enumerate() {
                assert_eq!(column(&recording, &format!("g.{i}")), expected, "{i} {toc}");
            }
        }
    }
}

#[test]
fn complex_numbers_become_two_columns_and_singles_keep_their_value() {
    for order in [LITTLE, BIG] {
        let singles = [1.5_f32, -0.1, 2.0, 3.0].map(|x| order.bytes(&x.to_le_bytes())).concat();
        let doubles = [0.1, 0.2, 0.3, 0.4_f64].map(|x| order.bytes(&x.to_le_bytes())).concat();
        let objects = [
            order.object("/'g'/'s'", &order.index(0x0008_000c, 2), &[]),
            order.object("/'g'/'d'", &order.index(0x0010_000d, 2), &[("unit_string", Prop::Text("V"))]),
        ];
        let recording = file(&order.segment(USUAL, &objects, &[singles, doubles].concat()));
        assert_eq!(names(&recording), [["g.s.re", "g.s.im", "g.d.re", "g.d.im"]]);
        assert_eq!(column(&recording, "g.s.im"), [f64::from(-0.1_f32), 3.0]);
        assert_eq!((column(&recording, "g.d.re"), column(&recording, "g.d.im")), (&[0.1, 0.3][..], &[0.2, 0.4][..]));
        assert_eq!(recording.tables[0].column("d.im").unwrap().unit.as_deref(), Some("V"));
    }
}

#[test]
fn text_is_kept_with_its_lengths_also_the_empty_one_and_what_is_not_utf8() {
    for order in [LITTLE, BIG] {
        let texts: [&[u8]; 4] = [b"on", b"", "°C".as_bytes(), b"\xb0"];
        let mut end = 0;
        let ends: Vec<u8> = texts
            .iter()
            .flat_map(|text| {
                end += u32::try_from(text.len()).unwrap();
                order.u32(end)
            })
            .collect();
        let data = [ends, texts.concat()].concat();
        let object = order.object("/'g'/'state'", &order.text_index(4, data.len() as u64), &[]);
        // The same twice: two chunks. A single channel of text stands alike in both layouts.
        for toc in [USUAL, USUAL | INTERLEAVED] {
            let recording =
                file(&order.segment(toc, std::slice::from_ref(&object), &[data.clone(), data.clone()].concat()));
            assert_eq!(text(&recording, "state"), ["on", "", "°C", "°", "on", "", "°C", "°"]);
            assert_eq!(recording.findings, []);
        }
    }
}

#[test]
fn instants_are_seconds_since_the_first_one_to_the_last_fraction() {
    for order in [LITTLE, BIG] {
        let tenth = 1_844_674_407_370_955_162;
        let data = [order.stamp(3_600, 1 << 63), order.stamp(3_601, tenth), order.stamp(3_599, 0)].concat();
        let object = order.object("/'g'/'t'", &order.index(0x44, 3), &[]);
        let recording = file(&order.segment(USUAL, &[object], &data));
        assert_eq!(column(&recording, "g.t"), [0.5, 1.1, -1.0]);
        assert_eq!(recording.origin.as_deref(), Some("1904-01-01T01:00:00Z"));
        assert!(recording.tables[0].columns[0].is_dated);
        // An instant that was not set is no origin: later ones would lose their last digits.
        let unset = [order.stamp(0, 0), order.stamp(DAY, 1 << 63), order.stamp(DAY, tenth)].concat();
        let object = order.object("/'g'/'t'", &order.index(0x44, 3), &[]);
        let late = file(&order.segment(USUAL, &[object], &unset));
        assert_eq!(column(&late, "g.t")[1..], [0.5, 0.1]);
        let column = &recording.tables[0].columns[0];
        assert_eq!(column.unit.as_deref(), Some("s"));
        assert!(column.clock.is_some());
    }
}

#[test]
fn what_a_segment_does_not_say_is_as_before() {
    let recording = file(&two_channels());
    let p: Vec<f64> = (0..18).map(f64::from).collect();
    let f: Vec<f64> = p.iter().map(|x| -x).collect();
    assert_eq!((column(&recording, "rig.p"), column(&recording, "rig.F")), (&p[..], &f[..]));
    assert_eq!(recording.findings, []);
    assert_eq!(names(&recording), [["rig.time", "rig.p", "rig.F"]]);
    let time: Vec<f64> = (0..18).map(|i| f64::from(i) * 0.01).collect();
    assert_eq!(column(&recording, "rig.time"), time);
    assert!(!recording.tables[0].columns[0].is_dated);
    assert_eq!((recording.tables[0].clock, recording.origin), (Some(0), None));
}

#[test]
fn a_channel_joins_pauses_and_comes_back() {
    let index = LITTLE.index(3, 2);
    let [p, f] = [P, F].map(|path| LITTLE.object(path, &index, &[]));
    let bytes = [
        LITTLE.segment(USUAL, std::slice::from_ref(&p), &i32s(&[1, 2])),
        // Appended to the list.
        LITTLE.segment(METADATA | RAW, &[f], &i32s(&[3, 4, 10, 20])),
        // Without values in this segment; the other as before.
        LITTLE.segment(METADATA | RAW, &[LITTLE.object(P, &LITTLE.no_data(), &[])], &i32s(&[30, 40])),
        // With values again, as they stood when that was last said.
        LITTLE.segment(METADATA | RAW, &[LITTLE.object(P, &LITTLE.as_before(), &[])], &i32s(&[5, 6, 50, 60])),
        // A new list with one of them, other values at once.
        LITTLE.segment(USUAL, &[LITTLE.object(F, &LITTLE.index(3, 1), &[])], &i32s(&[70, 80, 90])),
        // No metadata: the list of the segment before.
        LITTLE.segment(RAW, &[], &i32s(&[100])),
        // Nothing but metadata.
        LITTLE.segment(METADATA, &[LITTLE.object("/'rig'", &LITTLE.no_data(), &[("who", Prop::Text("me"))])], &[]),
    ]
    .concat();
    let recording = file(&bytes);
    assert_eq!(column(&recording, "rig.p"), [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
    assert_eq!(column(&recording, "rig.F"), [10.0, 20.0, 30.0, 40.0, 50.0, 60.0, 70.0, 80.0, 90.0, 100.0]);
    // Other lengths are other tables, under the name of their group.
    assert_eq!(names(&recording), [["rig.p"], ["rig.F"]]);
    assert_eq!(recording.metadata, ["rig: who: me"]);
    assert_eq!(recording.findings, []);
}

#[test]
fn every_segment_may_have_its_own_order_of_bytes() {
    let bytes = [
        LITTLE.segment(USUAL, &[LITTLE.object(P, &LITTLE.index(3, 1), &[])], &i32s(&[1])),
        BIG.segment(USUAL, &[BIG.object(P, &BIG.index(3, 1), &[])], &2_i32.to_be_bytes()),
        BIG.segment(RAW, &[], &3_i32.to_be_bytes()),
        LITTLE.segment(RAW, &[], &4_i32.to_le_bytes()),
    ]
    .concat();
    assert_eq!(column(&file(&bytes), "rig.p"), [1.0, 2.0, 3.0, 4.0]);
}

#[test]
fn metadata_that_are_repeated_mean_what_they_meant_also_behind_a_segment_without_any() {
    let index = LITTLE.index(3, 1);
    let [p, f] = [P, F].map(|path| LITTLE.object(path, &index, &[]));
    let only_p = LITTLE.segment(USUAL, std::slice::from_ref(&p), &i32s(&[1]));
    let both = LITTLE.segment(USUAL, &[p, f], &i32s(&[2, 3]));
    let bytes = [
        only_p.clone(),
        only_p.clone(),
        both.clone(),
        both.clone(),
        only_p,
        LITTLE.segment(RAW, &[], &i32s(&[1])),
        both,
    ]
    .concat();
    let recording = file(&bytes);
    assert_eq!(column(&recording, "rig.p"), [1.0, 1.0, 2.0, 2.0, 1.0, 1.0, 2.0]);
    assert_eq!(column(&recording, "rig.F"), [3.0, 3.0, 3.0]);
}

#[test]
fn a_last_chunk_may_be_shorter_in_a_segment_that_is_whole() {
    let index = LITTLE.index(3, 2);
    let objects = [LITTLE.object(P, &index, &[]), LITTLE.object(F, &index, &[])];
    let recording = file(&LITTLE.segment(USUAL, &objects, &i32s(&[1, 2, 10, 20, 3, 30])));
    assert_eq!(
        (column(&recording, "rig.p"), column(&recording, "rig.F")),
        (&[1.0, 2.0, 3.0][..], &[10.0, 20.0, 30.0][..])
    );
    assert_eq!(told(&recording.findings), [(FindingKind::CountMismatch, Severity::Note)]);
    // Where the file ends within that chunk, its values stay those of their channels.
    let whole = LITTLE.segment(USUAL, &objects, &i32s(&[1, 2, 10, 20, 3, 30]));
    let cut = file(&whole[..whole.len() - 2]);
    assert_eq!((column(&cut, "rig.p"), column(&cut, "rig.F")[..2].to_vec()), (&[1.0, 2.0, 3.0][..], vec![10.0, 20.0]));
    assert!(column(&cut, "rig.F")[2].is_nan());
    assert_eq!(told(&cut.findings), [CUT]);
    // Three bytes that no value fills are told.
    let recording = file(&LITTLE.segment(USUAL, &objects, &[i32s(&[1, 2, 10, 20, 3, 30]), vec![0; 3]].concat()));
    assert_eq!(column(&recording, "rig.p").len(), 3);
    assert_eq!(
        told(&recording.findings),
        [(FindingKind::CountMismatch, Severity::Lost), (FindingKind::CountMismatch, Severity::Note)]
    );
    assert!(
        recording.findings[0].text.contains("3 bytes of raw data belong to no channel"),
        "{}",
        recording.findings[0].text
    );
}

/// Counts of a card with two channels of 16 bits, four samples.
fn card(props: &[(&str, Prop)]) -> Vec<u8> {
    let index = |place, id| LITTLE.daqmx(u32::MAX, false, 4, &[(3, 0, place, id)], &[4]);
    let objects = [LITTLE.object(P, &index(0, 0), props), LITTLE.object(F, &index(2, 0), &[])];
    LITTLE.segment(USUAL | INTERLEAVED | DAQMX, &objects, &i16s(&[1, -10, 2, -20, 3, -30, 4, -40]))
}

const LINEAR: [(&str, Prop); 5] = [
    ("NI_Number_Of_Scales", Prop::U32(2)),
    ("NI_Scale[1]_Scale_Type", Prop::Text("Linear")),
    ("NI_Scale[1]_Linear_Slope", Prop::F64(0.5)),
    ("NI_Scale[1]_Linear_Y_Intercept", Prop::F64(10.0)),
    ("NI_Scale[1]_Linear_Input_Source", Prop::U32(0)),
];

#[test]
fn counts_of_a_card_are_scaled_or_told_to_be_counts() {
    let recording = file(&card(&LINEAR));
    assert_eq!(column(&recording, "rig.p"), [10.5, 11.0, 11.5, 12.0]);
    assert_eq!(column(&recording, "rig.F"), [-10.0, -20.0, -30.0, -40.0]);
    assert_eq!(told(&recording.findings), [(FindingKind::Unscaled, Severity::Note)]);
    assert_eq!(recording.findings[0].channel.as_deref(), Some("rig.F"));
}

#[test]
fn a_channel_with_two_scalers_takes_both_also_from_two_buffers() {
    // The scale adds the scalers 0 and 1.
    let add = [
        ("NI_Number_Of_Scales", Prop::U32(3)),
        ("NI_Scale[2]_Scale_Type", Prop::Text("Add")),
        ("NI_Scale[2]_Add_Left_Operand_Input_Source", Prop::U32(0)),
        ("NI_Scale[2]_Add_Right_Operand_Input_Source", Prop::U32(1)),
    ];
    let index = LITTLE.daqmx(u32::MAX, false, 3, &[(3, 0, 0, 0), (3, 1, 2, 1)], &[2, 4]);
    let data = i16s(&[1, 2, 3, 0, 100, 0, 200, 0, 300]);
    for (props, expected) in [(&add[..], vec![vec!["rig.p"]]), (&[], vec![vec!["rig.p[0]", "rig.p[1]"]])] {
        let recording = file(&LITTLE.segment(
            USUAL | DAQMX,
            &[LITTLE.object(P, &index, props)],
            &[data.clone(), data.clone()].concat(),
        ));
        assert_eq!(names(&recording), expected);
        if props.is_empty() {
            assert_eq!(column(&recording, "rig.p[1]"), [100.0, 200.0, 300.0, 100.0, 200.0, 300.0]);
        } else {
            assert_eq!(column(&recording, "rig.p"), [101.0, 202.0, 303.0, 101.0, 202.0, 303.0]);
        }
    }
    // One of the two is asked for by its name.
    let bytes = LITTLE.segment(USUAL | DAQMX, &[LITTLE.object(P, &index, &[])], &data);
    let asked = [ColumnRef::Name("rig.p[1]".to_owned())];
    let recording = read(&RawFile::of_bytes("r.tdms", &bytes), Keep::Only(&asked)).unwrap();
    assert_eq!(column(&recording, "rig.p[1]"), [100.0, 200.0, 300.0]);
}

#[test]
fn instants_of_a_card_are_instants_also_where_metadata_come_again() {
    let index = |place| LITTLE.daqmx(0x44, false, 1, &[(u32::MAX, 0, place, 0)], &[18]);
    let segment = |place: u32, seconds| {
        let stamp = LITTLE.stamp(seconds, 1 << 63);
        let row = if place == 0 { [stamp, vec![0; 2]].concat() } else { [vec![0; 2], stamp].concat() };
        LITTLE.segment(USUAL | DAQMX, &[LITTLE.object(P, &index(place), &[])], &row)
    };
    let recording = file(&[segment(0, DAY), segment(2, DAY + 1)].concat());
    assert_eq!((column(&recording, "rig.p"), &recording.findings), (&[0.5, 1.5][..], &vec![]));
    assert_eq!(recording.tables[0].columns[0].unit.as_deref(), Some("s"));
}

#[test]
fn lines_of_a_digital_port_are_bits() {
    for order in [LITTLE, BIG] {
        // Three lines of a port of 32 bits: the lowest, the ninth and the last.
        let objects: Vec<Vec<u8>> = [0, 8, 31]
            .iter()
            .map(|line| {
                let index = order.daqmx(7, true, 3, &[(4, 0, *line, 0)], &[4]);
                order.object(&format!("/'port'/'line{line}'"), &index, &[])
            })
            .collect();
        let data: Vec<u8> = [1_u32, 1 << 8, 1 << 31 | 1].iter().flat_map(|port| order.u32(*port)).collect();
        let recording = file(&order.segment(USUAL | DAQMX, &objects, &data));
        assert_eq!(column(&recording, "port.line0"), [1.0, 0.0, 1.0]);
        assert_eq!(column(&recording, "port.line8"), [0.0, 1.0, 0.0]);
        assert_eq!(column(&recording, "port.line31"), [0.0, 0.0, 1.0]);
    }
}

#[test]
fn a_scale_stated_behind_its_values_holds_for_them_too() {
    let index = LITTLE.index(3, 2);
    let bytes = [
        LITTLE.segment(USUAL, &[LITTLE.object(P, &index, &[])], &i32s(&[1, 2])),
        LITTLE.segment(USUAL, &[LITTLE.object(P, &index, &linear_of_raw(2.0))], &i32s(&[3, 4])),
    ]
    .concat();
    let recording = file(&bytes);
    assert_eq!(column(&recording, "rig.p"), [2.0, 4.0, 6.0, 8.0]);
    assert!(recording.reasons.iter().any(|reason| reason.contains("behind values")), "{:?}", recording.reasons);
    // The scale of a group holds for its channels, and so does that of the file.
    for (path, factor) in [("/'rig'", 3.0), ("/", 4.0)] {
        let parent = LITTLE.object(path, &LITTLE.no_data(), &linear_of_raw(factor));
        let recording = file(&LITTLE.segment(USUAL, &[parent, LITTLE.object(P, &index, &[])], &i32s(&[1, 2])));
        assert_eq!(column(&recording, "rig.p"), [factor, 2.0 * factor]);
    }
}

fn linear_of_raw(slope: f64) -> [(&'static str, Prop<'static>); 5] {
    [
        ("NI_Number_Of_Scales", Prop::U32(1)),
        ("NI_Scale[0]_Scale_Type", Prop::Text("Linear")),
        ("NI_Scale[0]_Linear_Slope", Prop::F64(slope)),
        ("NI_Scale[0]_Linear_Y_Intercept", Prop::F64(0.0)),
        ("NI_Scale[0]_Linear_Input_Source", Prop::U32(u32::MAX)),
    ]
}

#[test]
fn raw_numbers_never_stand_for_a_scale_that_is_not_known() {
    let index = LITTLE.index(10, 2);
    let thermocouple = [("NI_Number_Of_Scales", Prop::U32(1)), ("NI_Scale[0]_Scale_Type", Prop::Text("Thermocouple"))];
    let data = f64s(&[1.0, 2.0, 3.0, 4.0]);
    let objects = [LITTLE.object(P, &index, &[]), LITTLE.object(F, &index, &thermocouple)];
    let bytes = LITTLE.segment(USUAL, &objects, &data);
    let recording = file(&bytes);
    assert_eq!(names(&recording), [["rig.p"]]);
    assert_eq!(column(&recording, "rig.p"), [1.0, 2.0]);
    assert_eq!(told(&recording.findings), [(FindingKind::UnsupportedScaling, Severity::Lost)]);
    assert!(recording.findings[0].text.contains("Thermocouple"), "{}", recording.findings[0].text);
    // Where it is asked for, and where nothing else is there, it is an error that names it.
    let asked = [ColumnRef::Name("rig.F".to_owned())];
    let refused = read(&RawFile::of_bytes("r.tdms", &bytes), Keep::Only(&asked)).unwrap_err().to_string();
    assert!(refused.contains("rig.F") && refused.contains("Thermocouple"), "{refused}");
    let alone = error(&LITTLE.segment(USUAL, &[objects[1].clone()], &data));
    assert!(alone.contains("Thermocouple"), "{alone}");
    // Scaled already is scaled.
    let scaled = [thermocouple[0], thermocouple[1], ("NI_Scaling_Status", Prop::Text("scaled"))];
    let recording = file(&LITTLE.segment(USUAL, &[LITTLE.object(F, &index, &scaled)], &f64s(&[1.0, 2.0])));
    assert_eq!(column(&recording, "rig.F"), [1.0, 2.0]);
}

#[test]
fn types_whose_size_nobody_states_are_errors_that_name_them() {
    for (code, name) in
        [(11, "extended-precision"), (0x1b, "extended-precision"), (0x4f, "fixed-point"), (99, "unknown type 0x63")]
    {
        let told = error(&LITTLE.segment(USUAL, &[LITTLE.object(P, &LITTLE.index(code, 1), &[])], &[0; 16]));
        assert!(told.contains(name) && told.contains("'rig'"), "{told}");
    }
}

fn wave(start: i64, fraction: u64, step: f64) -> [(&'static str, Prop<'static>); 3] {
    [
        ("wf_start_time", Prop::Time(start, fraction)),
        ("wf_start_offset", Prop::F64(0.5)),
        ("wf_increment", Prop::F64(step)),
    ]
}

const DAY: i64 = 3_871_000_000;

#[test]
fn waveforms_state_their_times_and_channels_that_share_them_share_a_table() {
    let index = LITTLE.index(10, 2);
    let paths = ["/'g'/'a'", "/'g'/'b'", "/'g'/'slow'", "/'g'/'plain'", "/'other'/'a'"];
    // Multiplexed cards state beginnings that no stamp can tell apart.
    let waves = [
        &wave(DAY, 1 << 62, 0.01)[..],
        &wave(DAY, (1 << 62) + (1 << 20), 0.01),
        &wave(DAY, 1 << 63, 0.1),
        &[],
        &wave(DAY, 1 << 63, 0.01),
    ];
    let objects: Vec<Vec<u8>> = paths.iter().zip(waves).map(|(path, wave)| LITTLE.object(path, &index, wave)).collect();
    let recording = file(&LITTLE.segment(USUAL, &objects, &f64s(&[0.0; 10])));
    assert_eq!(
        names(&recording),
        [vec!["g.time", "g.a", "g.b"], vec!["g.time (2)", "g.slow"], vec!["g.plain"], vec!["other.time", "other.a"]]
    );
    assert_eq!(recording.origin.as_deref(), Some("2026-08-31T05:46:40Z"));
    assert_eq!(column(&recording, "g.time"), [0.75, 0.76]);
    assert_eq!(column(&recording, "g.time (2)"), [1.0, 1.1]);
    assert_eq!(column(&recording, "other.time"), [1.0, 1.01]);
    let clocks: Vec<Option<usize>> = recording.tables.iter().map(|table| table.clock).collect();
    assert_eq!(clocks, [Some(0), Some(0), None, Some(0)]);
}

#[test]
fn a_channel_without_times_shares_those_of_the_only_table_that_is_as_long() {
    let objects = [
        LITTLE.object("/'g'/'valve'", &LITTLE.index(10, 2), &[]),
        LITTLE.object("/'g'/'a'", &LITTLE.index(10, 2), &[("wf_increment", Prop::F64(0.01))]),
        LITTLE.object("/'g'/'short'", &LITTLE.index(10, 1), &[]),
    ];
    let recording = file(&LITTLE.segment(USUAL, &objects, &f64s(&[0.0; 5])));
    assert_eq!(names(&recording), [vec!["g.time", "g.valve", "g.a"], vec!["g.short"]]);
}

#[test]
fn an_acquisition_that_begins_anew_in_the_same_channel_begins_anew_in_time() {
    let index = LITTLE.index(10, 2);
    let again = |start| LITTLE.segment(USUAL, &[LITTLE.object(P, &index, &wave(start, 0, 0.01))], &f64s(&[0.0, 1.0]));
    let recording = file(&[again(DAY), again(DAY + 60), again(DAY + 60)].concat());
    assert_eq!(column(&recording, "rig.time"), [0.5, 0.51, 60.5, 60.51, 60.52, 60.53]);
    assert_eq!(told(&recording.findings), [(FindingKind::ConflictingDefinition, Severity::Note)]);
    assert!(recording.findings[0].text.contains("sample 2"), "{}", recording.findings[0].text);
    // What is set behind the last value corrects all of them.
    let object = LITTLE.object(P, &LITTLE.no_data(), &[("wf_increment", Prop::F64(0.02))]);
    let recording = file(&[again(DAY), LITTLE.segment(METADATA, &[object], &[])].concat());
    assert_eq!(column(&recording, "rig.time"), [0.5, 0.52]);
    assert_eq!(recording.findings, []);
}

#[test]
fn a_spectrum_has_no_clock() {
    let props = [
        ("wf_increment", Prop::F64(2.0)),
        ("wf_xname", Prop::Text("Frequency")),
        ("wf_xunit_string", Prop::Text("Hz")),
        ("wf_start_time", Prop::Time(DAY, 0)),
    ];
    let recording = file(&LITTLE.segment(USUAL, &[LITTLE.object(P, &LITTLE.index(10, 2), &props)], &f64s(&[1.0, 2.0])));
    assert_eq!(column(&recording, "rig.Frequency"), [0.0, 2.0]);
    assert_eq!((recording.tables[0].clock, recording.tables[0].columns[0].unit.as_deref()), (None, Some("Hz")));
}

#[test]
fn names_that_meet_are_told_apart() {
    let index = LITTLE.index(10, 1);
    let objects = [
        LITTLE.object("/'g'/'time'", &index, &[("wf_increment", Prop::F64(1.0))]),
        LITTLE.object("/'g'/'z'", &LITTLE.index(0x0010_000d, 1), &[]),
        LITTLE.object("/'g'/'z.re'", &index, &[]),
    ];
    let recording = file(&LITTLE.segment(USUAL, &objects, &f64s(&[1.0, 2.0, 3.0, 4.0])));
    assert_eq!(names(&recording), [["g.time (2)", "g.time", "g.z.re (2)", "g.z.im", "g.z.re"]]);
    assert_eq!(column(&recording, "g.z.re"), [4.0]);
}

#[test]
fn only_what_is_asked_for_is_kept_with_its_clock() {
    let bytes = two_channels();
    let asked = [ColumnRef::Name("rig.F".to_owned())];
    let recording = read(&RawFile::of_bytes("r.tdms", &bytes), Keep::Only(&asked)).unwrap();
    assert_eq!(column(&recording, "rig.F").len(), 18);
    assert_eq!(column(&recording, "rig.time").len(), 18);
    assert_eq!(recording.tables[0].column("p").unwrap().cells, Cells::NotKept);
    let looked_at = read(&RawFile::of_bytes("r.tdms", &bytes), Keep::Nothing).unwrap();
    let table: &Table = &looked_at.tables[0];
    assert_eq!((table.rows, table.column("p").unwrap().summary.range), (18, Some((0.0, 17.0))));
    assert!(table.columns.iter().all(|column| column.cells == Cells::NotKept));
}

#[test]
fn a_file_is_known_by_its_first_bytes_and_an_index_is_told_from_it() {
    let bytes = two_channels();
    assert_eq!(detect(&RawFile::of_bytes("r.bin", &bytes)).unwrap(), Format::Tdms);
    let metadata = LITTLE.metadata(&[LITTLE.object(P, &LITTLE.index(10, 3), &[])]);
    let index = [LITTLE.lead(*b"TDSh", USUAL, metadata.len() as u64 + 48, metadata.len() as u64), metadata].concat();
    assert_eq!(detect(&RawFile::of_bytes("r.tdms_index", &index)).unwrap(), Format::Tdms);
    let told = read(&RawFile::of_bytes("r.tdms_index", &index), Keep::All).unwrap_err().to_string();
    assert!(told.contains("1 channels with 6 values") && told.contains("read r.tdms beside it"), "{told}");
}

/// Bytes of the second and of the third segment of [`two_channels`]: lead-in, one object, values.
const SECOND: usize = 28 + 4 + 22 + 96;
const THIRD: usize = 28 + 96;

/// What stands in a prefix of [`two_channels`] that is `length` bytes long: values of the first and of the second channel.
fn values_before(length: usize) -> (usize, usize) {
    let whole = two_channels();
    let (mut at, mut values) = (0, (0, 0));
    while at + 28 <= length {
        let number = |from: usize| u64::from_le_bytes(whole[from..from + 8].try_into().unwrap());
        let (next, raw) = (usize::try_from(number(at + 12)).unwrap(), usize::try_from(number(at + 20)).unwrap());
        let begin = at + 28 + raw;
        let there = length.min(at + 28 + next).saturating_sub(begin) / 8;
        for value in 0..there {
            if value % 6 < 3 { values.0 += 1 } else { values.1 += 1 }
        }
        at += 28 + next;
    }
    values
}

#[test]
fn a_cut_at_any_byte_leaves_every_whole_value_before_it_and_is_told_where_it_can_be() {
    let bytes = two_channels();
    let whole = file(&bytes);
    let ends = [bytes.len() - THIRD - SECOND, bytes.len() - THIRD];
    let mut read_some = 0;
    for cut in 0..bytes.len() {
        let raw = RawFile::of_bytes("r.tdms", &bytes[..cut]);
        let Ok(recording) = read(&raw, Keep::All) else {
            assert!(values_before(cut) == (0, 0) && cut < ends[0], "{cut}");
            continue;
        };
        read_some += 1;
        let (p, f) = values_before(cut);
        let rows = p.max(f);
        for (name, count) in [("rig.p", p), ("rig.F", f)] {
            let (there, expected) = (column(&recording, name), column(&whole, name));
            assert_eq!(there.len(), rows, "{cut} {name}");
            assert_eq!(there[..count], expected[..count], "{cut} {name}");
            assert!(there[count..].iter().all(|value| value.is_nan()), "{cut} {name}");
        }
        let is_told = recording.findings.iter().any(|f| (f.kind, f.severity) == CUT);
        assert_eq!(is_told, !ends.contains(&cut), "{cut}: {:?}", recording.findings);
    }
    assert!(read_some > 250, "{read_some}");
}

#[test]
fn a_channel_that_is_cut_short_is_named_with_what_is_left_of_it() {
    let bytes = two_channels();
    let recording = file(&bytes[..bytes.len() - 20]);
    let text = &recording.findings[0].text;
    assert!(text.contains("76 of 96 bytes") && text.contains("`rig.F` has 15 values of the 18"), "{text}");
    // The program stopped before it could say how long the segment is.
    let mut open = bytes.clone();
    let last = bytes.len() - THIRD;
    open[last + 12..last + 20].fill(0xff);
    let recording = file(&open);
    assert_eq!(column(&recording, "rig.p").len(), 18);
    assert_eq!(told(&recording.findings), [CUT]);
    assert!(recording.findings[0].text.contains("was never closed"), "{}", recording.findings[0].text);
}

#[test]
fn zero_bytes_and_other_bytes_behind_the_last_segment_are_told_apart() {
    let bytes = two_channels();
    let zeros = file(&[bytes.clone(), vec![0; 1000]].concat());
    assert!(zeros.findings[0].text.contains("1000 zero bytes"), "{}", zeros.findings[0].text);
    let other = file(&[bytes.clone(), b"garbage that is long enough to be a lead-in".to_vec()].concat());
    assert_eq!(told(&other.findings), [(FindingKind::BadRecord, Severity::Lost)]);
    for recording in [zeros, other] {
        assert_eq!(column(&recording, "rig.p").len(), 18);
    }
}

#[test]
fn behind_a_damaged_segment_nothing_is_used_and_it_is_said_why() {
    let bytes = two_channels();
    let second = bytes.len() - THIRD - SECOND;
    // The length of its path.
    let mut damaged = bytes.clone();
    damaged[second + 28 + 4] = 0xee;
    let recording = file(&damaged);
    assert_eq!(column(&recording, "rig.p"), [0.0, 1.0, 2.0, 3.0, 4.0, 5.0]);
    assert_eq!(told(&recording.findings), [(FindingKind::BadRecord, Severity::Lost)]);
    assert!(
        recording.findings[0].text.contains(&format!("segment at byte {second}")),
        "{}",
        recording.findings[0].text
    );
    // The first one: nothing is left.
    let mut damaged = bytes;
    damaged[28 + 4] = 0xee;
    assert!(error(&damaged).contains("a first segment that cannot be used"));
}

#[test]
fn flipped_bits_end_in_an_error_or_in_findings_and_never_in_a_panic() {
    let files = [two_channels(), card(&LINEAR), {
        let data = [LITTLE.u32(2), LITTLE.u32(4), b"onof".to_vec()].concat();
        LITTLE.segment(USUAL, &[LITTLE.object("/'g'/'state'", &LITTLE.text_index(2, data.len() as u64), &[])], &data)
    }];
    let mut read_some = 0;
    for bytes in files {
        for bit in 0..bytes.len() * 8 {
            let mut flipped = bytes.clone();
            flipped[bit / 8] ^= 1 << (bit % 8);
            if let Ok(recording) = read(&RawFile::of_bytes("r.tdms", &flipped), Keep::All) {
                read_some += 1;
                for table in &recording.tables {
                    assert!(table.columns.iter().all(|column| column.cells.len() == table.rows), "{bit}");
                    assert!(table.rows < 1000, "{bit}: {} rows", table.rows);
                }
            }
        }
    }
    assert!(read_some > 2000, "{read_some}");
}

#[test]
fn lengths_that_no_file_has_ask_for_no_memory() {
    let huge = u64::MAX / 2;
    for index in
        [LITTLE.index(10, huge), LITTLE.index(5, huge), LITTLE.text_index(huge, huge), LITTLE.text_index(1 << 40, 16)]
    {
        let told = match read(
            &RawFile::of_bytes("r", &LITTLE.segment(USUAL, &[LITTLE.object(P, &index, &[])], &[0; 64])),
            Keep::All,
        ) {
            Ok(recording) => format!("{:?}", recording.findings),
            Err(error) => error.to_string(),
        };
        assert!(told.contains("bytes") || told.contains("larger than any file"), "{told}");
    }
    // A lead-in that states more metadata than there are bytes, and one that states a next segment before its own data.
    let lead = |next, raw| LITTLE.lead(*b"TDSm", USUAL, next, raw);
    assert!(error(&lead(1 << 50, 1 << 49)).contains("ends before its values begin"));
    assert!(error(&[lead(4, 8), vec![0; 64]].concat()).contains("behind its end"));
}

#[test]
fn many_channels_on_the_same_byte_are_no_way_to_fill_the_memory() {
    // 4,000 channels of one byte each row.
    let index = LITTLE.daqmx(5, true, 1 << 16, &[(0, 0, 0, 0)], &[1]);
    let objects: Vec<Vec<u8>> = (0..4_000).map(|i| LITTLE.object(&format!("/'g'/'{i}'"), &index, &[])).collect();
    let told = error(&LITTLE.segment(USUAL | DAQMX, &objects, &vec![1; 1 << 16]));
    assert!(told.contains("many channels take the same bytes"), "{told}");
}

#[test]
fn layouts_that_cannot_be_are_errors_that_say_why() {
    let numbers = LITTLE.object(P, &LITTLE.index(3, 2), &[]);
    let texts = LITTLE.object("/'rig'/'s'", &LITTLE.text_index(1, 8), &[]);
    let card = LITTLE.object("/'rig'/'c'", &LITTLE.daqmx(3, false, 2, &[(5, 0, 0, 0)], &[4]), &[]);
    let cases = [
        (USUAL | INTERLEAVED, vec![numbers.clone(), texts], "text stands between numbers"),
        (
            USUAL | INTERLEAVED,
            vec![numbers.clone(), LITTLE.object(F, &LITTLE.index(3, 1), &[])],
            "one has 2 values and another 1",
        ),
        (USUAL, vec![numbers.clone(), card], "channels of DAQ cards stand beside others"),
        (USUAL, vec![LITTLE.object(P, &LITTLE.as_before(), &[])], "should stand as before"),
        (USUAL, vec![LITTLE.object("rig/p", &LITTLE.no_data(), &[])], "no path"),
        (USUAL, vec![LITTLE.object("/'rig'", &LITTLE.index(3, 2), &[])], "only channels can"),
        (USUAL, vec![LITTLE.object(P, &LITTLE.daqmx(3, false, 2, &[(5, 0, 2, 0)], &[4]), &[])], "takes bytes up to 6"),
        (
            USUAL,
            vec![LITTLE.object(P, &LITTLE.daqmx(2, false, 2, &[(5, 0, 0, 0)], &[4]), &[])],
            "states values of the type int16",
        ),
        (
            USUAL,
            vec![LITTLE.object(P, &LITTLE.daqmx(u32::MAX, false, 2, &[(3, 0, 0, 7), (3, 0, 2, 7)], &[4]), &[])],
            "scaler 7 twice",
        ),
        (RAW, vec![], "no metadata"),
    ];
    for (toc, objects, expected) in cases {
        let told = error(&LITTLE.segment(toc, &objects, &[0; 16]));
        assert!(told.contains(expected), "{expected}: {told}");
    }
    assert!(error(b"").contains("an empty file"));
    assert!(error(b"TDSm").contains("the file is cut"));
    assert!(error(b"something else altogether, and long").contains("other bytes"));
}

#[test]
fn properties_are_kept_as_metadata_of_file_group_and_channel() {
    let objects = [
        LITTLE.object(
            "/",
            &LITTLE.no_data(),
            &[("operator", Prop::Text("M. Ito")), ("begun", Prop::Time(DAY, 1 << 63))],
        ),
        LITTLE.object("/'rig'", &LITTLE.no_data(), &[("dry", Prop::Bool(true)), ("runs", Prop::I32(-3))]),
        LITTLE.object(P, &LITTLE.index(10, 1), &[("unit_string", Prop::Text("kPa")), ("gain", Prop::F64(0.1))]),
    ];
    let recording = file(&LITTLE.segment(USUAL, &objects, &f64s(&[1.0])));
    assert_eq!(
        recording.metadata,
        [
            "begun: 2026-08-31T05:46:40.5Z",
            "operator: M. Ito",
            "rig: dry: true",
            "rig: runs: -3",
            "rig.p: gain: 0.1",
            "rig.p: unit_string: kPa"
        ]
    );
    assert_eq!(recording.tables[0].columns[0].unit.as_deref(), Some("kPa"));
}

#[test]
fn thousands_of_small_segments_give_what_one_large_one_gives() {
    let index = |count| LITTLE.index(10, count);
    let objects = |count| [LITTLE.object(P, &index(count), &[]), LITTLE.object(F, &index(count), &[])];
    let value = |i: u32| (f64::from(i) * 0.7).sin();
    let p: Vec<f64> = (0..5_000).map(value).collect();
    let f: Vec<f64> = (5_000..10_000).map(value).collect();
    let large = LITTLE.segment(USUAL, &objects(5_000), &[f64s(&p), f64s(&f)].concat());
    let small: Vec<u8> = p
        .chunks(5)
        .zip(f.chunks(5))
        .flat_map(|(p, f)| LITTLE.segment(USUAL, &objects(5), &[f64s(p), f64s(f)].concat()))
        .collect();
    let (large, small) = (file(&large), file(&small));
    assert_eq!(large.tables, small.tables);
    assert_eq!(column(&small, "rig.F"), f);
}

#[test]
fn values_that_a_scale_does_not_hold_for_are_holes_that_are_told() {
    let thermistor = [
        ("NI_Number_Of_Scales", Prop::U32(1)),
        ("NI_Scale[0]_Scale_Type", Prop::Text("Thermistor")),
        ("NI_Scale[0]_Thermistor_Excitation_Type", Prop::U32(10_322)),
        ("NI_Scale[0]_Thermistor_Excitation_Value", Prop::F64(2.5)),
        ("NI_Scale[0]_Thermistor_Resistance_Configuration", Prop::U32(4)),
        ("NI_Scale[0]_Thermistor_R1_Reference_Resistance", Prop::F64(5_000.0)),
        ("NI_Scale[0]_Thermistor_Lead_Wire_Resistance", Prop::F64(0.0)),
        ("NI_Scale[0]_Thermistor_A", Prop::F64(0.001_295_361)),
        ("NI_Scale[0]_Thermistor_B", Prop::F64(0.000_234_315_9)),
        ("NI_Scale[0]_Thermistor_C", Prop::F64(1.018_703e-7)),
        ("NI_Scale[0]_Thermistor_Temperature_Offset", Prop::F64(273.15)),
        ("NI_Scale[0]_Thermistor_Input_Source", Prop::U32(u32::MAX)),
    ];
    let object = LITTLE.object(P, &LITTLE.index(10, 4), &thermistor);
    let recording = file(&LITTLE.segment(USUAL, &[object], &f64s(&[1.25, -1.0, f64::NAN, 1.5])));
    let numbers = column(&recording, "rig.p");
    // Half of the excitation falls off: the thermistor has 5 kOhm, which it has at 25 degrees.
    assert!((numbers[0] - 25.0).abs() < 0.5 && numbers[3] < numbers[0], "{numbers:?}");
    assert!(numbers[1].is_nan() && numbers[2].is_nan());
    assert_eq!(told(&recording.findings), [(FindingKind::OutOfRange, Severity::Excluded)]);
    assert_eq!((recording.findings[0].count, recording.findings[0].spans[0].first_sample), (1, 1));
}

#[test]
fn a_scale_of_a_group_or_file_stated_behind_values_holds_for_them_and_one_that_changes_is_told() {
    let index = LITTLE.index(3, 2);
    for (path, named) in [("/'rig'", "group `rig`"), ("/", "the file"), (P, "channel `rig.p`")] {
        let stated = |slope| LITTLE.object(path, &LITTLE.no_data(), &linear_of_raw(slope));
        let late = [
            LITTLE.segment(USUAL, &[LITTLE.object(P, &index, &[])], &i32s(&[1, 2])),
            LITTLE.segment(METADATA, &[stated(2.0)], &[]),
        ]
        .concat();
        let recording = file(&late);
        assert_eq!(column(&recording, "rig.p"), [2.0, 4.0], "{path}");
        assert_eq!(recording.findings, []);
        let again = file(&[late, LITTLE.segment(METADATA, &[stated(3.0)], &[])].concat());
        assert_eq!(column(&again, "rig.p"), [3.0, 6.0], "{path}");
        assert_eq!(told(&again.findings), [(FindingKind::ConflictingDefinition, Severity::Note)]);
        assert!(again.findings[0].text.contains(named), "{}", again.findings[0].text);
    }
    // A group that nobody has read from concerns nobody.
    let other = LITTLE.object("/'other'", &LITTLE.no_data(), &linear_of_raw(2.0));
    let bytes = [
        LITTLE.segment(USUAL, &[LITTLE.object(P, &index, &[])], &i32s(&[1, 2])),
        LITTLE.segment(METADATA, &[other], &[]),
    ];
    let recording = file(&bytes.concat());
    assert_eq!(column(&recording, "rig.p"), [1.0, 2.0]);
    assert!(!recording.reasons.iter().any(|reason| reason.contains("scale")), "{:?}", recording.reasons);
}

#[test]
fn a_scale_stated_before_the_first_value_holds_also_where_values_were_described_before_it() {
    let bytes = [
        LITTLE.segment(METADATA | NEW_LIST, &[LITTLE.object(P, &LITTLE.index(3, 2), &[])], &[]),
        LITTLE.segment(METADATA | RAW, &[LITTLE.object(P, &LITTLE.as_before(), &linear_of_raw(2.0))], &i32s(&[1, 2])),
    ];
    assert_eq!(column(&file(&bytes.concat()), "rig.p"), [2.0, 4.0]);
}

#[test]
fn a_segment_without_metadata_says_itself_whether_values_stand_in_rows() {
    let index = LITTLE.index(3, 2);
    let objects = [LITTLE.object(P, &index, &[]), LITTLE.object(F, &index, &[])];
    let bytes = [
        LITTLE.segment(USUAL, &objects, &i32s(&[1, 2, -1, -2])),
        LITTLE.segment(RAW | INTERLEAVED, &[], &i32s(&[3, -3, 4, -4])),
        LITTLE.segment(RAW, &[], &i32s(&[5, 6, -5, -6])),
    ];
    let recording = file(&bytes.concat());
    assert_eq!(column(&recording, "rig.p"), [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
    assert_eq!(column(&recording, "rig.F"), [-1.0, -2.0, -3.0, -4.0, -5.0, -6.0]);
}

#[test]
fn a_short_chunk_of_a_card_is_told_and_does_not_move_what_follows() {
    // Scaler 0 in the first buffer, scaler 1 in the second; a scale that adds them, or none.
    let add = [
        ("NI_Number_Of_Scales", Prop::U32(3)),
        ("NI_Scale[2]_Scale_Type", Prop::Text("Add")),
        ("NI_Scale[2]_Add_Left_Operand_Input_Source", Prop::U32(0)),
        ("NI_Scale[2]_Add_Right_Operand_Input_Source", Prop::U32(1)),
    ];
    for buffers in [[0, 1], [1, 0]] {
        let index = LITTLE.daqmx(u32::MAX, false, 3, &[(3, buffers[0], 0, 0), (3, buffers[1], 0, 1)], &[2, 2]);
        for props in [&add[..], &[]] {
            let first = LITTLE.segment(USUAL | DAQMX, &[LITTLE.object(P, &index, props)], &i16s(&[1, 2, 3, 100]));
            let short = [first.clone(), LITTLE.segment(RAW, &[], &i16s(&[7, 8, 9, 700, 800, 900]))].concat();
            let recording = file(&short);
            if props.is_empty() {
                let [a, b] = buffers.map(|buffer| format!("rig.p[{buffer}]"));
                assert_eq!(column(&recording, &a), [1.0, 7.0, 8.0, 9.0]);
                assert_eq!(column(&recording, &b), [100.0, 700.0, 800.0, 900.0]);
            } else {
                assert_eq!(column(&recording, "rig.p"), [101.0, 707.0, 808.0, 909.0]);
            }
            assert!(
                recording.findings.iter().any(|f| f.kind == FindingKind::CountMismatch),
                "{:?}",
                recording.findings
            );
            // Half a value more belongs to nobody.
            let odd = LITTLE.segment(
                USUAL | DAQMX,
                &[LITTLE.object(P, &index, props)],
                &[i16s(&[1, 2, 3, 100]), vec![1]].concat(),
            );
            let lost = (FindingKind::CountMismatch, Severity::Lost);
            assert!(told(&file(&odd).findings).contains(&lost));
            // Where the file ends so, it is cut: columns stay as long as their table.
            let cut = file(&first[..first.len() - 1]);
            assert!(cut.tables.iter().all(|table| table.columns.iter().all(|c| c.cells.len() == table.rows)));
            let cut = file(&[first, LITTLE.segment(RAW, &[], &i16s(&[7, 8, 9, 700]))].concat()[..]);
            assert!(cut.tables.iter().all(|table| table.columns.iter().all(|c| c.cells.len() == table.rows)));
        }
    }
}

#[test]
fn counts_that_no_file_has_are_summed_without_going_round() {
    let half = 1_u64 << 63;
    let texts = LITTLE.text_index(1, 8);
    let plain = [LITTLE.object(P, &LITTLE.index(5, half), &[]), LITTLE.object("/'rig'/'s'", &texts, &[])];
    let card = [LITTLE.object(P, &LITTLE.daqmx(5, false, half, &[(0, 0, 0, 0)], &[1]), &[])];
    for (toc, objects) in [(USUAL, &plain[..]), (USUAL | DAQMX, &card), (USUAL, &plain[..1])] {
        let one = LITTLE.segment(toc, objects, &[1, 2, 3]);
        let recording = file(&[one.clone(), one.clone(), one].concat());
        assert_eq!(column(&recording, "rig.p"), [1.0, 2.0, 3.0, 1.0, 2.0, 3.0, 1.0, 2.0, 3.0]);
        assert!(told(&recording.findings).contains(&(FindingKind::CountMismatch, Severity::Note)));
    }
}

#[test]
fn texts_of_a_chunk_that_is_cut_are_no_more_than_its_bytes() {
    // Sixteen million texts are stated, and the second ends before the first.
    let stated = 16 << 20;
    let index = LITTLE.text_index(stated, stated * 4);
    let data = [LITTLE.u32(0), LITTLE.u32(4), LITTLE.u32(2), LITTLE.u32(9)].concat();
    let mut bytes = LITTLE.segment(USUAL, &[LITTLE.object("/'g'/'state'", &index, &[])], &data);
    bytes[12..20].copy_from_slice(&u64::MAX.to_le_bytes());
    let recording = file(&bytes);
    assert!(recording.tables[0].rows <= 4, "{} rows", recording.tables[0].rows);
    assert!(told(&recording.findings).contains(&CUT));
}

#[test]
fn a_channel_that_begins_anew_thousands_of_times_is_followed() {
    let index = LITTLE.index(10, 1);
    let segment =
        |i: i64| LITTLE.segment(USUAL, &[LITTLE.object(P, &index, &wave(DAY + i * 7, 0, 0.01))], &f64s(&[1.0]));
    let recording = file(&(0..6_000).map(segment).collect::<Vec<_>>().concat());
    let expected: Vec<f64> = (0..6_000).map(|i| f64::from(i) * 7.0 + 0.5).collect();
    assert_eq!(column(&recording, "rig.time"), expected);
    assert_eq!((told(&recording.findings).len(), recording.findings[0].count), (1, 5_999));
}

#[test]
fn a_beginning_stated_anew_where_the_time_stands_anyway_is_no_change() {
    let index = LITTLE.index(10, 2);
    // A step of 1/8 s: two samples are a quarter of a second.
    let again = |seconds, quarters: u64| {
        let wave = wave(DAY + seconds, quarters << 62, 0.125);
        LITTLE.segment(USUAL, &[LITTLE.object(P, &index, &wave)], &f64s(&[0.0, 1.0]))
    };
    let recording = file(&[again(0, 3), again(1, 0), again(1, 1)].concat());
    assert_eq!(column(&recording, "rig.time"), [1.25, 1.375, 1.5, 1.625, 1.75, 1.875]);
    assert_eq!(recording.findings, []);
    // A thousandth of a second late is one, from the sample on at which it is.
    let late = [("wf_start_time", Prop::Time(DAY + 1, 1 << 54))];
    let late = LITTLE.segment(USUAL, &[LITTLE.object(P, &index, &late)], &f64s(&[0.0, 1.0]));
    let recording = file(&[again(0, 3), late].concat());
    assert_eq!(column(&recording, "rig.time")[2..], [1.5 + 2.0_f64.powi(-10), 1.625 + 2.0_f64.powi(-10)]);
    assert_eq!(told(&recording.findings), [(FindingKind::ConflictingDefinition, Severity::Note)]);
}

#[test]
fn an_axis_in_another_unit_of_time_is_in_seconds_and_one_of_no_time_is_no_clock() {
    let of = |props: &[(&str, Prop)]| {
        let props = [&[("wf_increment", Prop::F64(250.0)), ("wf_start_offset", Prop::F64(1_000.0))], props].concat();
        file(&LITTLE.segment(USUAL, &[LITTLE.object(P, &LITTLE.index(10, 2), &props)], &f64s(&[1.0, 2.0])))
    };
    let time = ("wf_xname", Prop::Text("Time"));
    let recording = of(&[time, ("wf_xunit_string", Prop::Text("ms"))]);
    assert_eq!(column(&recording, "rig.time"), [1.0, 1.25]);
    assert_eq!(recording.tables[0].columns[0].unit.as_deref(), Some("s"));
    assert_eq!(column(&of(&[time]), "rig.time"), [1_000.0, 1_250.0]);
    // Its name says that it is no time, though no unit does.
    let recording = of(&[("wf_xname", Prop::Text("Frequency"))]);
    assert_eq!(column(&recording, "rig.Frequency"), [1_000.0, 1_250.0]);
    assert_eq!((recording.tables[0].clock, recording.tables[0].columns[0].unit.as_deref()), (None, None));
}

#[test]
fn a_clock_without_a_date_beside_others_with_one_is_told() {
    let index = LITTLE.index(10, 2);
    let objects = [
        LITTLE.object("/'dated'/'a'", &index, &wave(DAY, 0, 0.01)),
        LITTLE.object("/'free'/'a'", &index, &[("wf_increment", Prop::F64(0.01))]),
    ];
    let recording = file(&LITTLE.segment(USUAL, &objects, &f64s(&[0.0; 4])));
    assert_eq!(told(&recording.findings), [(FindingKind::NoDate, Severity::Note)]);
    assert_eq!(recording.findings[0].channel.as_deref(), Some("free.time"));
    // Where no clock has one, there is nothing to confuse.
    assert_eq!(file(&LITTLE.segment(USUAL, &objects[1..], &f64s(&[0.0; 2]))).findings, []);
}

#[test]
fn channels_of_a_card_that_disagree_on_its_rows_are_an_error() {
    let object =
        |path, count, place| LITTLE.object(path, &LITTLE.daqmx(u32::MAX, false, count, &[(3, 0, place, 0)], &[4]), &[]);
    let told = error(&LITTLE.segment(USUAL | DAQMX, &[object(P, 4, 0), object(F, 2, 2)], &[0; 16]));
    assert!(told.contains("disagree on raw buffer 0: 4 and 2 rows"), "{told}");
    // A scale that takes scaler 0 could mean either.
    let twice = LITTLE.daqmx(u32::MAX, false, 4, &[(3, 0, 0, 0), (3, 0, 2, 0)], &[4]);
    let told = error(&LITTLE.segment(USUAL | DAQMX, &[LITTLE.object(P, &twice, &LINEAR)], &[0; 16]));
    assert!(told.contains("scaler 0 twice"), "{told}");
    let scalers = vec![(3, 0, 0, 0); 1_000];
    let object = LITTLE.object(P, &LITTLE.daqmx(u32::MAX, false, 4, &scalers, &[4]), &[]);
    assert!(error(&LITTLE.segment(USUAL | DAQMX, &[object], &[0; 16])).contains("1000 scalers"));
    let object = LITTLE.object(P, &LITTLE.daqmx(u32::MAX, false, 4, &[(3, 0, 0, 0)], &[4; 2_000]), &[]);
    assert!(error(&LITTLE.segment(USUAL | DAQMX, &[object], &[0; 16])).contains("2000 raw buffers"));
}

#[test]
fn segments_without_a_value_for_thousands_of_channels_are_no_way_to_take_hours() {
    let index = LITTLE.index(5, 2);
    let objects: Vec<Vec<u8>> = (0..4_000).map(|i| LITTLE.object(&format!("/'g'/'{i}'"), &index, &[])).collect();
    let mut bytes = LITTLE.segment(USUAL, &objects, &vec![1; 8_000]);
    let short = LITTLE.segment(RAW, &[], &[1]);
    for _ in 0..20_000 {
        bytes.extend(&short);
    }
    let told = error(&bytes);
    assert!(told.contains("channels in segments of so few bytes"), "{told}");
    // As many segments that only set a property are no work.
    let mut bytes = LITTLE.segment(USUAL, &objects, &vec![1; 8_000]);
    let note = LITTLE.segment(METADATA, &[LITTLE.object("/", &LITTLE.no_data(), &[("n", Prop::I32(1))])], &[]);
    for _ in 0..20_000 {
        bytes.extend(&note);
    }
    assert_eq!(file(&bytes).findings, []);
    // Nor does a list of metadata in which each object is looked for among all before it.
    let new: Vec<Vec<u8>> = (0..60_000).map(|i| LITTLE.object(&format!("/'{i}'"), &LITTLE.index(5, 0), &[])).collect();
    let as_before = vec![LITTLE.object("/'59999'", &LITTLE.as_before(), &[]); 60_000];
    let p = LITTLE.object(P, &LITTLE.index(5, 1), &[]);
    let bytes = LITTLE.segment(USUAL, &[new, as_before, vec![p]].concat(), &[7]);
    assert_eq!(column(&file(&bytes), "rig.p"), [7.0]);
}

#[test]
fn texts_in_a_short_chunk_do_not_move_beside_numbers_that_are_whole() {
    let texts = [LITTLE.u32(1), LITTLE.u32(2), b"ab".to_vec()].concat();
    let objects =
        [LITTLE.object(P, &LITTLE.index(3, 2), &[]), LITTLE.object("/'rig'/'state'", &LITTLE.text_index(2, 10), &[])];
    let short = LITTLE.segment(USUAL, &objects, &[i32s(&[1, 2]), texts[..9].to_vec()].concat());
    let full = LITTLE.segment(USUAL, &objects, &[i32s(&[3, 4]), texts].concat());
    let recording = file(&[short, full].concat());
    // Three texts and four numbers are no rows of one table.
    assert_eq!(names(&recording), [["rig.p"], ["rig.state"]]);
    assert_eq!(text(&recording, "state"), ["a", "a", "b"]);
    assert_eq!(column(&recording, "rig.p"), [1.0, 2.0, 3.0, 4.0]);
    assert_eq!(told(&recording.findings), [(FindingKind::CountMismatch, Severity::Note)]);
}

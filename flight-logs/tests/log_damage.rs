//! Whatever the bytes: no panic, fields as long as the times, finite times; and what is whole beside damage is read.

mod support;

use flight_logs::{Log, parse};
use proptest::prelude::*;
use support::{blackbox, dataflash, dataflash_text, tlog, ulog, ulog_csv};

fn all() -> [(&'static str, Vec<u8>); 6] {
    [
        ("log.ulg", ulog(50)),
        ("log.bin", dataflash(50)),
        ("log.log", dataflash_text(50)),
        ("log.bbl", blackbox(50)),
        ("log.tlog", tlog(50)),
        ("log_sensor_combined_0.csv", ulog_csv(50)),
    ]
}

fn sound(logs: &[Log]) {
    for topic in logs.iter().flat_map(|log| &log.topics) {
        assert!(!topic.time_s.is_empty() && topic.time_s.iter().all(|time_s| time_s.is_finite()));
        assert!(topic.fields.iter().all(|field| field.values.len() == topic.time_s.len()), "{}", topic.name);
    }
}

/// Reads bytes that may be damaged; the number of all rows.
fn rows(name: &str, bytes: &[u8]) -> usize {
    match parse(name, bytes) {
        Ok(logs) => {
            sound(&logs);
            logs.iter().flat_map(|log| &log.topics).map(|topic| topic.time_s.len()).sum()
        }
        Err(error) => {
            assert!(!error.found.is_empty() && !error.advice.is_empty());
            assert!(error.to_string().lines().count() <= 3, "{error}");
            0
        }
    }
}

#[test]
fn logs_that_end_anywhere() {
    for (name, bytes) in all() {
        let whole = rows(name, &bytes);
        assert!(whole >= 50, "{name}: {whole} rows");
        for end in 0..bytes.len() {
            let read = rows(name, &bytes[..end]);
            assert!(read <= whole, "{name}: more rows from fewer bytes");
        }
        assert!(rows(name, &bytes[..bytes.len() - 1]) + 1 >= whole, "{name}: only the last message is lost");
    }
}

#[test]
fn every_single_byte_damaged() {
    for (name, bytes) in all() {
        for at in 0..bytes.len() {
            for mask in [0xff, 0x01, 0x80] {
                let mut damaged = bytes.clone();
                damaged[at] ^= mask;
                rows(name, &damaged);
            }
        }
    }
}

#[test]
fn foreign_bytes_in_the_middle_cost_little_and_are_counted() {
    for (name, bytes) in
        all().into_iter().filter(|(name, _)| !name.ends_with("csv") && !name.ends_with("log"))
    {
        let whole = rows(name, &bytes);
        let middle = 3 * bytes.len() / 4;
        let mut damaged = bytes[..middle].to_vec();
        damaged.extend((0..40_u8).map(|i| i.wrapping_mul(97) | 0x80));
        damaged.extend(&bytes[middle..]);
        let logs = parse(name, &damaged).unwrap();
        sound(&logs);
        assert!(logs[0].notes.iter().any(|note| note.contains("bad bytes")), "{name}: {:?}", logs[0].notes);
        let read = rows(name, &damaged);
        assert!((whole - 10..=whole).contains(&read), "{name}: {read} of {whole} rows");
    }
}

#[test]
fn a_log_of_several_blocks_is_read_as_one() {
    let once = ulog(60_000);
    let data = &once[ulog(0).len()..];
    let long = [&once[..], data, data].concat();
    assert!(long.len() > 5 << 20, "{}", long.len());
    let whole = rows("log.ulg", &long);
    assert_eq!(whole, 3 * rows("log.ulg", &once));
    let (mut damaged, mut places) = (Vec::new(), 0);
    for piece in long.chunks(70_001) {
        damaged.extend(piece);
        damaged.extend([0xff; 500]);
        places += 1;
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("log.ulg");
    std::fs::write(&path, &damaged).unwrap();
    let logs = flight_logs::read(&[&path]).unwrap();
    sound(&logs);
    assert!(
        logs[0].notes.iter().any(|note| note.contains(&format!("{places} places"))),
        "{:?}",
        logs[0].notes
    );
    let read: usize = logs[0].topics.iter().map(|topic| topic.time_s.len()).sum();
    assert_eq!(read, rows("log.ulg", &damaged));
    assert!((whole - 10 * places..=whole).contains(&read), "{read} of {whole} rows in {places} places");
}

#[test]
fn bytes_that_are_no_log_are_refused_with_advice() {
    for bytes in [&b""[..], b"PK\x03\x04", b"t_s,u_rad\n0,1\n", &[0; 1000], b"ULo"] {
        let error = parse("odd.bin", bytes).expect_err("no log");
        assert_eq!(error.file.as_deref(), Some("odd.bin"));
        assert!(!error.advice.is_empty());
    }
    let error = parse("a.ulg", &ulog(0)[..16]).expect_err("a header alone");
    assert_eq!(
        error.to_string(),
        "a.ulg, offset 16: no message can be read\n  expected: ULog messages\n  advice: log again: nothing but a \
         header was written"
    );
}

#[test]
fn sizes_from_the_file_allocate_nothing() {
    // Formats of 65535 bytes, each subscribed 256 times, without a row; a count beyond every memory.
    let mut bytes = ulog(0);
    for i in 0..500 {
        let name = format!("topic{i}");
        support::message(
            &mut bytes,
            b'F',
            format!("{name}:uint8_t[65000] a;float[4000000000] b;").as_bytes(),
        );
        support::message(&mut bytes, b'F', format!("{name}x:uint8_t[65000] a;").as_bytes());
        for instance in 0..=255_u8 {
            let mut body = vec![instance, instance, i as u8];
            body.extend(format!("{name}x").as_bytes());
            support::message(&mut bytes, b'A', &body);
        }
    }
    let logs = parse("big.ulg", &bytes).unwrap();
    assert!(logs[0].topics.is_empty());
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, ..ProptestConfig::default() })]

    #[test]
    fn damaged_logs(
        which in 0..6_usize,
        flips in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 0..30),
        cut in any::<prop::sample::Index>(),
        paste in any::<prop::sample::Index>(),
    ) {
        let (name, mut bytes) = all()[which].clone();
        for (at, value) in flips {
            let at = at.index(bytes.len());
            bytes[at] = value;
        }
        let (from, to) = (cut.index(bytes.len()), paste.index(bytes.len()));
        bytes.drain(from.min(to)..from.max(to).min(from.min(to) + 60));
        rows(name, &bytes);
    }

    #[test]
    fn any_bytes_behind_a_good_start(which in 0..6_usize, tail in prop::collection::vec(any::<u8>(), 0..2000)) {
        let (name, bytes) = all()[which].clone();
        let mut bytes = bytes[..bytes.len() / 2].to_vec();
        bytes.extend(tail);
        rows(name, &bytes);
    }
}

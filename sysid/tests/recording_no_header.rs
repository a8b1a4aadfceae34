//! Files that begin with a row of numbers.

use sysid::recording::{ReadOptions, Recording, parse};

fn read(columns: &[&str]) -> Result<Recording, sysid::error::Error> {
    let row = |k: usize| format!("{},{:.4},{},\n", 20 * k, (0.05 * k as f64).sin(), k % 7 % 2);
    let text = (0..200).map(row).collect::<String>();
    let columns = columns.iter().map(|map| map.parse().unwrap()).collect();
    parse("a.csv", text.as_bytes(), &ReadOptions { columns, ..ReadOptions::default() })
}

#[test]
fn columns_are_called_by_their_places() {
    let read = read(&["t_s=c1/1000", "theta_deg=c2", "u_norm=c3"]).unwrap();
    assert_eq!(
        (read.len(), read.step, read.u[..8].to_vec()),
        (200, 0.02, vec![0.0, 1.0, 0.0, 1.0, 0.0, 1.0, 0.0, 0.0])
    );
    let told = "the file has no header: from the left its columns are c1 to c4";
    assert!(read.notes.iter().any(|note| note.text == told), "{:?}", read.notes);
}

#[test]
fn what_is_not_there_is_told() {
    let refused = read(&["t_s=c1/1000", "u_norm=c9"]).unwrap_err().to_string();
    assert!(refused.contains("the file has no column \"c9\""), "{refused}");
    let refused = read(&["t_s=c1/1000", "u_norm=c3"]).unwrap_err().to_string();
    assert!(refused.contains("neither pitch rate nor pitch angle among c1, c2, c3, c4"), "{refused}");
}

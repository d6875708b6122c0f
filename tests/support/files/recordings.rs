//! Files of data, good ones, to be broken.

use std::io::Write as _;

use flate2::Compression;
use flate2::write::ZlibEncoder;

pub const ROWS: usize = 200;

/// [s] 200 rows at 1 kHz.
pub fn times() -> Vec<f64> {
    (0..ROWS).map(|row| row as f64 * 0.001).collect()
}

pub fn positions() -> Vec<f64> {
    times().iter().map(|time| (20.0 * time).sin()).collect()
}

/// A CSV file of time, position and torque under a header.
pub fn csv(header: &str) -> String {
    let rows =
        times().into_iter().zip(positions()).map(|(time, position)| format!("{time:.3},{position},{}\n", -position));
    format!("{header}\n{}", rows.collect::<String>())
}

pub fn run_csv() -> String {
    csv("time,turn.position,turn.torque")
}

/// The same with this time in each row.
pub fn timed(time: impl Fn(usize) -> String) -> String {
    let row = |(row, position): (usize, f64)| format!("{},{position},{}\n", time(row), -position);
    format!("time,turn.position,turn.torque\n{}", positions().into_iter().enumerate().map(row).collect::<String>())
}

/// The same with one piece replaced.
#[track_caller]
pub fn changed(from: &str, to: &str) -> String {
    let good = run_csv();
    assert!(good.contains(from), "{from}");
    good.replacen(from, to, 1)
}

pub fn element(kind: u32, content: &[u8]) -> Vec<u8> {
    let mut element = [kind.to_le_bytes(), (content.len() as u32).to_le_bytes()].concat();
    element.extend(content);
    element.resize(element.len().next_multiple_of(8), 0);
    element
}

/// An array of a MATLAB 5 file: class, size, name, type and bytes of its numbers.
pub fn array(class: u32, size: &[i32], name: &str, kind: u32, numbers: &[u8]) -> Vec<u8> {
    let flags: Vec<u8> = [class, 0].into_iter().flat_map(u32::to_le_bytes).collect();
    let size: Vec<u8> = size.iter().copied().flat_map(i32::to_le_bytes).collect();
    let parts = [element(6, &flags), element(5, &size), element(1, name.as_bytes()), element(kind, numbers)];
    element(14, &parts.concat())
}

pub fn doubles(name: &str, values: &[f64]) -> Vec<u8> {
    let numbers: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
    array(6, &[values.len() as i32, 1], name, 9, &numbers)
}

/// Compresses an element.
pub fn compressed(element: &[u8]) -> Vec<u8> {
    let packed = zlib(element);
    let mut bytes = [15_u32.to_le_bytes(), (packed.len() as u32).to_le_bytes()].concat();
    bytes.extend(packed);
    bytes
}

pub fn zlib(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::best());
    encoder.write_all(bytes).expect("compressed");
    encoder.finish().expect("compressed")
}

/// A MATLAB 5 file of elements.
pub fn mat(elements: &[Vec<u8>]) -> Vec<u8> {
    let mut bytes = vec![b' '; 116];
    bytes[..19].copy_from_slice(b"MATLAB 5.0 MAT-file");
    bytes.extend([0; 8]);
    bytes.extend([0x00, 0x01, b'I', b'M']);
    bytes.extend(elements.concat());
    bytes
}

/// A recording as a MATLAB 5 file.
pub fn run_mat() -> Vec<u8> {
    mat(&[doubles("time", &times()), doubles("turn.position", &positions()), doubles("turn.torque", &positions())])
}

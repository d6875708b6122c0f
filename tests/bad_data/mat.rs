//! MATLAB 5 files.

use super::support::recordings::{array, compressed, doubles, element, mat, positions, run_mat, times, zlib};
use super::{Folder, each_is_refused};

#[test]
fn regress_broken_matlab_files_are_refused() {
    let good = run_mat();
    let (time, position) = (times(), positions());
    let with = |third: Vec<u8>| mat(&[doubles("time", &time), doubles("turn.position", &position), third]);
    let mut nan = position.clone();
    nan[41] = f64::NAN;
    let numbers: Vec<u8> = position.iter().flat_map(|value| value.to_le_bytes()).collect();
    let torque = |size: &[i32], kind: u32, bytes: &[u8]| array(6, size, "turn.torque", kind, bytes);
    let mut complex = torque(&[200, 1], 9, &numbers);
    complex[17] = 0x08;
    let mut checksum = compressed(&doubles("turn.torque", &position));
    let last = checksum.len() - 1;
    checksum[last] ^= 0x55;
    let mut packed = compressed(&doubles("turn.torque", &position));
    packed.truncate(packed.len() / 2);
    let length = packed.len() as u32 - 8;
    packed[4..8].copy_from_slice(&length.to_le_bytes());
    let mut swapped = good.clone();
    swapped[126..128].copy_from_slice(b"MI");
    let damaged = "array 3 = damaged";
    each_is_refused(
        "run.mat",
        &[
            (good[..good.len() - 100].to_vec(), &["array 3 = cut off", "a whole file"][..]),
            (good[..133].to_vec(), &["array 1 = cut off"]),
            (good[..60].to_vec(), &["format", "MATLAB 5"]),
            (b"\x89HDF\r\n\x1a\n".to_vec(), &["format = HDF5", "h5py"]),
            (b"MATLAB 7.3 MAT-file".to_vec(), &["format = MATLAB 7.3", "-v7"]),
            (swapped, &["array 1 = element type 234881024"]),
            (with(element(99, &[0; 16])), &["array 3 = element type 99", "an array (14 or 15)"]),
            (with(doubles("turn.torque", &position[..150])), &["row 150", "turn.torque = 150 samples", "shorter"]),
            (with(doubles("turn.torque", &nan)), &["row 42", "turn.torque = NaN", "finite"]),
            (with(torque(&[20, 5, 2], 9, &numbers)), &["turn.torque = 20×5×2", "a vector, or a matrix"]),
            (with(complex), &["turn.torque = complex numbers", "real numbers"]),
            (with(torque(&[199, 1], 9, &numbers)), &[damaged]),
            (with(torque(&[i32::MAX, 1], 9, &numbers)), &["size = ", "100000000 cells"]),
            (with(torque(&[i32::MAX, i32::MAX, i32::MAX], 9, &numbers)), &["turn.torque = 2147483647×2147483647"]),
            (with(torque(&[-1, 1], 9, &numbers)), &["size = ", "100000000 cells"]),
            (with(torque(&[200, 1], 14, &numbers)), &[damaged]),
            (with(torque(&[200, 1], 77, &numbers)), &[damaged]),
            (with(element(14, &element(6, &[6, 0]))), &[damaged]),
            (with(element(14, &[0xff; 40])), &[damaged]),
            (with(checksum), &[damaged]),
            (with(packed), &["array 3 = cut off"]),
            (with(element(15, b"no zlib here at all.....")), &[damaged]),
            (with(doubles("time", &time)), &["column = time", "once"]),
            (mat(&[]), &["columns = none", "columns of numbers"]),
            (mat(&[doubles("time", &time)]), &["columns = time", "joints turn"]),
        ],
    );
}

#[test]
fn regress_a_compressed_array_that_inflates_to_gigabytes_is_refused_at_once() {
    // 3 GB of zeros in 3 MB: the tag says so, or lies, or the array says that it has fewer numbers.
    let zeros = vec![0_u8; 64 << 20];
    let mut encoder = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::fast());
    let write = |encoder: &mut flate2::write::ZlibEncoder<Vec<u8>>, bytes: &[u8]| {
        std::io::Write::write_all(encoder, bytes).expect("compressed");
    };
    let head = |length: u32, size: i32, bytes: u32| {
        let mut array = array(6, &[size, 1], "turn.torque", 9, &[]);
        array[4..8].copy_from_slice(&length.to_le_bytes());
        let at = array.len() - 4;
        array[at..].copy_from_slice(&bytes.to_le_bytes());
        array
    };
    write(&mut encoder, &head(3_100_000_000, 380_000_000, 3_040_000_000));
    for _ in 0..12 {
        write(&mut encoder, &zeros);
    }
    let bomb = encoder.finish().expect("compressed");
    let pack = |packed: Vec<u8>| {
        [15_u32.to_le_bytes().to_vec(), (packed.len() as u32).to_le_bytes().to_vec(), packed].concat()
    };
    let small = zlib(&[head(1_000_000_000, 120_000_000, 960_000_000), vec![0; 1 << 20]].concat());
    let text = zlib(&[array(4, &[1, 100], "note", 4, &[]), zeros].concat());
    let with = |third: Vec<u8>| mat(&[doubles("time", &times()), doubles("turn.position", &positions()), pack(third)]);
    each_is_refused(
        "run.mat",
        &[(with(bomb), &["array 3 = damaged"][..]), (with(small), &["size = 120000400 rows", "100000000 cells"])],
    );
    // What is no number is not inflated at all.
    let folder = Folder::new();
    folder.put("run.mat", with(text));
    folder.reads("run.mat", &["200 samples"]);
}

#[test]
fn regress_arrays_of_every_type_are_read() {
    let (time, position) = (times(), positions());
    let whole: Vec<i64> = (0..200).map(|row| row - 100).collect();
    let bytes =
        |width: usize| whole.iter().flat_map(|value| value.to_le_bytes()[..width].to_vec()).collect::<Vec<u8>>();
    let single: Vec<u8> = position.iter().flat_map(|value| (*value as f32).to_le_bytes()).collect();
    // Class, type, numbers: as MATLAB stores them, narrower than the class where they fit.
    let cases = [
        (6, 3, bytes(2)),
        (6, 1, bytes(1)),
        (6, 5, bytes(4)),
        (8, 1, bytes(1)),
        (10, 3, bytes(2)),
        (12, 5, bytes(4)),
        (14, 12, bytes(8)),
        (7, 7, single),
    ];
    let folder = Folder::new();
    for (class, kind, numbers) in cases {
        let torque = array(class, &[1, 200], "turn.torque", kind, &numbers);
        let others = [doubles("time", &time), compressed(&doubles("turn.position", &position))];
        for third in [torque.clone(), compressed(&torque)] {
            let path = folder.put("run.mat", mat(&[others[0].clone(), others[1].clone(), third]));
            let session = lostmotion::dataset::load_alone(&path).expect("read");
            let torque = session.series.joints[0].get(lostmotion::timeseries::Channel::Torque).expect("torque");
            for (row, value) in torque.iter().enumerate() {
                let expected = if kind == 7 { f64::from(position[row] as f32) } else { whole[row] as f64 };
                assert_eq!(*value, expected, "class {class}, type {kind}, row {row}");
            }
        }
    }
}

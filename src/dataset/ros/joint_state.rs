//! The message `sensor_msgs/JointState` in the encodings of ROS 1 and of ROS 2 (CDR).
//!
//! ```text
//!   header: [seq u32, ROS 1 only]  stamp: i32 or u32 s, u32 ns  frame_id: string
//!   name: string[]   position, velocity, effort: f64[]           (the last three may be empty)
//! ```
//! A string and a list begin with their length as u32. CDR begins with four bytes that give the byte order, aligns
//! every number to its size and ends strings with a zero; ROS 1 is packed and little-endian.

/// Encoding of a message.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Wire {
    Ros1,
    Cdr,
    /// One that is not read, by its name.
    Other(String),
}

/// One message.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct JointState {
    /// Seconds and nanoseconds.
    pub(crate) stamp: (i64, u32),
    pub(crate) names: Vec<String>,
    /// Position, velocity, effort: one value per joint, or none.
    lists: [Vec<f64>; 3],
}

/// Most joints of a message.
const MAX_JOINTS: u32 = 10_000;

/// Names of the three lists.
const QUANTITIES: [&str; 3] = ["position", "velocity", "effort"];

impl JointState {
    /// Joint and quantity of every value, quantity by quantity.
    pub(crate) fn quantities(&self) -> impl Iterator<Item = (&str, &'static str)> {
        let present = QUANTITIES.into_iter().zip(&self.lists).filter(|(_, list)| !list.is_empty());
        present.flat_map(|(quantity, _)| self.names.iter().map(move |name| (name.as_str(), quantity)))
    }

    /// The values in that order.
    pub(crate) fn values(&self) -> impl Iterator<Item = f64> {
        self.lists.iter().flatten().copied()
    }

    /// Whether names and lists are the same as those of another message.
    pub(crate) fn has_the_joints_of(&self, other: &Self) -> bool {
        self.names == other.names && (0..3).all(|i| self.lists[i].len() == other.lists[i].len())
    }
}

impl Wire {
    /// The encoding, from its name in a file.
    pub(crate) fn of_encoding(encoding: &str) -> Self {
        match encoding {
            "ros1" => Self::Ros1,
            "cdr" => Self::Cdr,
            other => Self::Other(other.to_owned()),
        }
    }

    /// Reads a message; `None` if it is cut off or its lists do not fit its names.
    pub(crate) fn joint_state(&self, bytes: &[u8]) -> Option<JointState> {
        let mut reader = match self {
            Self::Ros1 => Reader::packed(bytes),
            Self::Cdr => {
                let (head, bytes) = bytes.split_at_checked(4)?;
                Reader { bytes, at: 0, aligned: true, little_endian: head[1] & 1 == 1 }
            }
            Self::Other(_) => return None,
        };
        if *self == Self::Ros1 {
            reader.u32()?;
        }
        let seconds = reader.u32()?;
        // ROS 2 has signed seconds, ROS 1 unsigned ones.
        let seconds = if *self == Self::Cdr { i64::from(seconds.cast_signed()) } else { i64::from(seconds) };
        let stamp = (seconds, reader.u32()?);
        reader.string()?;
        let count = reader.u32().filter(|&count| count <= MAX_JOINTS)?;
        let names = (0..count).map(|_| reader.string()).collect::<Option<Vec<String>>>()?;
        let lists = [reader.list()?, reader.list()?, reader.list()?];
        let fits = lists.iter().all(|list| list.is_empty() || list.len() == names.len());
        (fits && !names.is_empty()).then_some(JointState { stamp, names, lists })
    }
}

/// Reads a message from front to back.
pub(crate) struct Reader<'a> {
    bytes: &'a [u8],
    at: usize,
    aligned: bool,
    little_endian: bool,
}

impl<'a> Reader<'a> {
    /// For packed bytes, least byte first.
    pub(crate) fn packed(bytes: &'a [u8]) -> Self {
        Self { bytes, at: 0, aligned: false, little_endian: true }
    }

    fn take(&mut self, count: usize) -> Option<&'a [u8]> {
        let piece = self.bytes.get(self.at..self.at.checked_add(count)?)?;
        self.at += count;
        Some(piece)
    }

    fn number<const N: usize>(&mut self) -> Option<[u8; N]> {
        if self.aligned {
            self.at = self.at.next_multiple_of(N);
        }
        let mut bytes: [u8; N] = self.take(N)?.try_into().ok()?;
        if !self.little_endian {
            bytes.reverse();
        }
        Some(bytes)
    }

    #[cfg(feature = "mcap")]
    pub(crate) fn u16(&mut self) -> Option<u16> {
        self.number().map(u16::from_le_bytes)
    }

    fn u32(&mut self) -> Option<u32> {
        self.number().map(u32::from_le_bytes)
    }

    pub(crate) fn string(&mut self) -> Option<String> {
        let length = self.u32()?;
        let bytes = self.take(usize::try_from(length).ok()?)?;
        let text = bytes.strip_suffix(&[0]).unwrap_or(bytes);
        String::from_utf8(text.to_vec()).ok()
    }

    fn list(&mut self) -> Option<Vec<f64>> {
        let count = self.u32()?;
        (0..count).map(|_| self.number().map(f64::from_le_bytes)).collect()
    }
}

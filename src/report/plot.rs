//! Content of a plot, and the mapping of its values to a rectangle; used by the SVG and by the recording.

/// Curves and points over one pair of axes.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Plot {
    /// Its title.
    pub title: String,
    /// Horizontal axis: quantity and unit.
    pub x: String,
    /// Vertical axis: quantity and unit.
    pub y: String,
    /// Drawn in this order.
    pub layers: Vec<Layer>,
    /// Whether it is one of several small plots in a row.
    pub small: bool,
    /// Name of its own file, without ending; empty if it has none.
    pub file: String,
}

/// One curve or cloud of points.
#[derive(Debug, Clone, PartialEq)]
pub struct Layer {
    /// Label in the legend; empty: none.
    pub label: String,
    /// How it is drawn.
    pub mark: Mark,
    /// What the layer shows; determines its colour.
    pub role: Role,
    /// `[x, y]` in the units of the axes; a point that is not finite interrupts a line.
    pub points: Vec<[f64; 2]>,
}

/// How a layer is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mark {
    /// A line through the points.
    Line,
    /// A dashed line through the points.
    Dashed,
    /// A dot at each point.
    Dots,
    /// A large dot at each point.
    Points,
    /// An area: the points are its outline.
    Band,
}

/// What a layer shows. The colours can be distinguished by colour-blind readers (palette of Okabe and Ito).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// The known truth.
    Truth,
    /// Recorded data.
    Measured,
    /// A fit.
    Fit,
    /// The nominal model.
    Before,
    /// The extended model.
    After,
    /// A command or a reference.
    Reference,
    /// The link, behind the gap.
    Link,
}

impl Role {
    /// Red, green, blue.
    pub const fn colour(self) -> [u8; 3] {
        match self {
            Self::Truth => [60, 60, 60],
            Self::Measured => [86, 180, 233],
            Self::Fit => [0, 114, 178],
            Self::Before => [213, 94, 0],
            Self::After => [0, 158, 115],
            Self::Reference => [150, 150, 150],
            Self::Link => [204, 121, 167],
        }
    }
}

impl Layer {
    /// A layer of points.
    pub fn new(label: impl Into<String>, mark: Mark, role: Role, points: Vec<[f64; 2]>) -> Self {
        Self { label: label.into(), mark, role, points }
    }
}

impl Plot {
    /// A plot without layers.
    pub fn new(title: impl Into<String>, x: impl Into<String>, y: impl Into<String>) -> Self {
        Self { title: title.into(), x: x.into(), y: y.into(), layers: Vec::new(), small: false, file: String::new() }
    }

    /// Adds a layer.
    #[must_use]
    pub fn with(mut self, layer: Layer) -> Self {
        self.layers.push(layer);
        self
    }

    /// A plot over time whose lines keep only the points that are visible in one of these frames. The drawing stays the
    /// same.
    #[must_use]
    pub fn thinned(mut self, frames: &[fn(&Self) -> Frame]) -> Self {
        let frames: Vec<Frame> = frames.iter().map(|frame| frame(&self)).collect();
        for layer in self.layers.iter_mut().filter(|layer| matches!(layer.mark, Mark::Line | Mark::Dashed)) {
            let mut kept = vec![false; layer.points.len()];
            for frame in &frames {
                frame.mark_shown(&layer.points, &mut kept);
            }
            let mut kept = kept.into_iter();
            layer.points.retain(|_| kept.next().unwrap_or(true));
            layer.points.shrink_to_fit();
        }
        self
    }

    /// Marks it as one of several small plots.
    #[must_use]
    pub const fn small(mut self) -> Self {
        self.small = true;
        self
    }

    /// Gives it a file of its own, where a report writes such files.
    #[must_use]
    pub fn in_file(mut self, name: impl Into<String>) -> Self {
        self.file = name.into();
        self
    }

    /// Whether there is nothing to draw.
    pub fn is_empty(&self) -> bool {
        let drawn = |layer: &&Layer| layer.mark != Mark::Band;
        !self.layers.iter().filter(drawn).any(|layer| layer.points.iter().any(|point| finite(*point)))
    }

    /// Smallest and largest finite value of coordinate `axis` (0 or 1), widened by a twentieth; `[0, 1]` if there is
    /// none.
    fn range(&self, axis: usize) -> [f64; 2] {
        let points = self.layers.iter().flat_map(|layer| &layer.points).filter(|point| finite(**point));
        let [low, high] = points.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], point| {
            [low.min(point[axis]), high.max(point[axis])]
        });
        if low > high {
            return [0.0, 1.0];
        }
        let margin = if high > low { 0.05 * (high - low) } else { 0.5 * low.abs().max(1e-9) };
        [low - margin, high + margin]
    }
}

fn finite([x, y]: [f64; 2]) -> bool {
    x.is_finite() && y.is_finite()
}

/// The rectangle of a plot and the values at its edges; the vertical pixel axis points down.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Frame {
    /// Pixels of the left and right edge.
    pub horizontal: [f64; 2],
    /// Pixels of the upper and lower edge.
    pub vertical: [f64; 2],
    /// Values at the left and right edge.
    pub x: [f64; 2],
    /// Values at the lower and upper edge.
    pub y: [f64; 2],
}

impl Frame {
    /// The frame of `plot` on that rectangle.
    pub fn new(plot: &Plot, horizontal: [f64; 2], vertical: [f64; 2]) -> Self {
        Self { horizontal, vertical, x: plot.range(0), y: plot.range(1) }
    }

    /// Pixel of a point.
    pub fn place(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let across = (x - self.x[0]) / (self.x[1] - self.x[0]);
        let up = (y - self.y[0]) / (self.y[1] - self.y[0]);
        [
            self.horizontal[0] + across * (self.horizontal[1] - self.horizontal[0]),
            self.vertical[1] - up * (self.vertical[1] - self.vertical[0]),
        ]
    }

    /// Pixels of the finite runs of a line, reduced to what is visible: first, lowest, highest and last point of each
    /// pixel column.
    pub fn lines(&self, points: &[[f64; 2]]) -> Vec<Vec<[f64; 2]>> {
        points
            .split(|point| !finite(*point))
            .filter(|run| !run.is_empty())
            .map(|run| thin(&run.iter().map(|&point| self.place(point)).collect::<Vec<_>>()))
            .collect()
    }

    /// Marks the points that [`lines`](Self::lines) draws, and those that interrupt the line.
    fn mark_shown(&self, points: &[[f64; 2]], shown: &mut [bool]) {
        let mut first = 0;
        for run in points.split(|point| !finite(*point)) {
            let placed: Vec<[f64; 2]> = run.iter().map(|&point| self.place(point)).collect();
            let mut column_at = first;
            for column in placed.chunk_by(|a, b| a[0].floor() == b[0].floor()) {
                ends(column).into_iter().for_each(|end| shown[column_at + end] = true);
                column_at += column.len();
            }
            first += run.len();
            if let Some(interruption) = shown.get_mut(first) {
                *interruption = true;
            }
            first += 1;
        }
    }

    /// Pixels of at most `most` finite points, evenly chosen.
    pub fn points(&self, points: &[[f64; 2]], most: usize) -> Vec<[f64; 2]> {
        let step = points.len().div_ceil(most.max(1)).max(1);
        points.iter().step_by(step).filter(|point| finite(**point)).map(|&point| self.place(point)).collect()
    }
}

/// First, lowest, highest and last point of each run of points in one pixel column, in their order.
fn thin(points: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let mut kept = Vec::new();
    for column in points.chunk_by(|a, b| a[0].floor() == b[0].floor()) {
        let mut ends = ends(column);
        ends.sort_unstable();
        kept.extend(
            ends.iter().enumerate().filter(|(at, end)| *at == 0 || ends[at - 1] != **end).map(|(_, end)| column[*end]),
        );
    }
    kept
}

/// Indices of the first, lowest, highest and last point of a pixel column, which has at least one point.
fn ends(column: &[[f64; 2]]) -> [usize; 4] {
    let by_height = |a: &usize, b: &usize| column[*a][1].total_cmp(&column[*b][1]);
    let lowest = (0..column.len()).min_by(by_height).unwrap_or(0);
    let highest = (0..column.len()).max_by(by_height).unwrap_or(0);
    [0, lowest, highest, column.len() - 1]
}

/// Round values between `low` and `high`, about `count` of them, and the number of decimals they need.
pub fn ticks([low, high]: [f64; 2], count: usize) -> (Vec<f64>, usize) {
    #[expect(clippy::cast_precision_loss, reason = "a handful")]
    let rough = (high - low) / count.max(1) as f64;
    if !(rough.is_finite() && rough > 0.0) {
        return (Vec::new(), 0);
    }
    let power = rough.log10().floor();
    let mantissa = rough / 10f64.powf(power);
    let nice = [1.0, 2.0, 5.0, 10.0].into_iter().find(|&nice| mantissa <= nice * 1.001).unwrap_or(10.0);
    let step = nice * 10f64.powf(power);
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped to 0 … 12")]
    let decimals = (-step.log10()).ceil().clamp(0.0, 12.0) as usize;
    let first = (low / step).ceil();
    let values = (0..=2 * count).map(|index| {
        #[expect(clippy::cast_precision_loss, reason = "a handful")]
        let value = (first + index as f64) * step;
        if value.abs() < 1e-9 * step { 0.0 } else { value }
    });
    (values.take_while(|value| *value <= high).collect(), decimals)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn property_ticks_are_round_and_inside() {
        assert_eq!(ticks([-0.9, 10.3], 6), (vec![0.0, 2.0, 4.0, 6.0, 8.0, 10.0], 0));
        assert_eq!(ticks([0.0, 0.31], 3).1, 1);
    }

    #[test]
    fn property_thinning_keeps_the_extremes_of_each_column() {
        let dense: Vec<[f64; 2]> = (0..10_000).map(|k| [f64::from(k) / 1000.0, f64::from(k).sin()]).collect();
        let thinned = thin(&dense);
        assert!(thinned.len() <= 40);
        let highest = |points: &[[f64; 2]]| points.iter().map(|p| p[1]).fold(f64::MIN, f64::max);
        assert_eq!(highest(&thinned), highest(&dense));
    }

    #[test]
    fn property_a_thinned_plot_draws_the_same() {
        let wave = |k: u32| if k.is_multiple_of(997) { f64::NAN } else { f64::from(k * k % 7919).sin() };
        let points: Vec<[f64; 2]> = (0..50_000).map(|k| [f64::from(k) * 1e-3, wave(k)]).collect();
        let plot = Plot::new("", "", "").with(Layer::new("", Mark::Line, Role::Fit, points));
        let frames: [fn(&Plot) -> Frame; 2] = [
            |plot| Frame::new(plot, [76.0, 666.0], [50.0, 314.0]),
            |plot| Frame::new(plot, [70.0, 625.0], [30.0, 345.0]),
        ];
        let thinned = plot.clone().thinned(&frames);
        assert!(thinned.layers[0].points.len() < 6000, "{}", thinned.layers[0].points.len());
        for frame in frames {
            let lines = |plot: &Plot| frame(plot).lines(&plot.layers[0].points);
            assert_eq!(lines(&thinned), lines(&plot));
        }
    }
}

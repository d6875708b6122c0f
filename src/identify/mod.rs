//! Friction and backlash from motor-side time series.

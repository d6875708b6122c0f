//! Rigid-body algorithms on the tree: one algorithm, one file.

//! Arrow matrices against dense ones.

use nalgebra::{DMatrix, DVector};

use super::super::arrow::{Arrow, ArrowLu, Shape};
use super::numbers;

const fn shape(blocks: usize, block: usize, border: usize) -> Shape {
    Shape { blocks, block, border }
}

/// An arrow matrix with random entries, and the same as a dense one. Diagonals are heavier, since
/// pivoting is inside a block.
fn random(shape: Shape, order: &[usize], seed: u32) -> (Arrow, DMatrix<f64>) {
    let n = shape.len();
    let mut arrow = Arrow::new(shape);
    if !order.is_empty() {
        arrow.reorder(order);
    }
    let entries = numbers(n * n, seed);
    let mut dense = DMatrix::zeros(n, n);
    for i in 0..n {
        for j in 0..n {
            if arrow.index(i, j).is_some() {
                let weight = if i == j { 0.5 * n as f64 } else { 0.0 };
                dense[(i, j)] = entries[i * n + j] + weight.min(8.0);
                arrow.add(i, j, dense[(i, j)]);
            }
        }
    }
    (arrow, dense)
}

/// Asserts that product and solution are the dense ones.
fn assert_like_dense(lu: &mut ArrowLu, shape: Shape, order: &[usize], seed: u32) {
    let n = shape.len();
    let (arrow, dense) = random(shape, order, seed);
    let x = numbers(n, seed + 1);
    let mut product = vec![f64::NAN; n];
    arrow.multiply(&x, &mut product);
    let column = DVector::from_column_slice(&x);
    let error = (DVector::from_vec(product) - &dense * &column).amax();
    assert!(error < 1e-12, "{shape:?}: {error:e}");
    lu.factor(&arrow).unwrap();
    let expected = dense.lu().solve(&column).expect("a regular matrix");
    let mut solution = x;
    lu.solve(&mut solution);
    let error = (DVector::from_vec(solution) - &expected).amax();
    assert!(error < 1e-9 * (1.0 + expected.amax()), "{shape:?}: {error:e}");
}

/// A permutation of the band that leaves the border where it is.
fn shuffled(shape: Shape, seed: u32) -> Vec<usize> {
    let split = shape.blocks * shape.block;
    let keys = numbers(split, seed);
    let mut order: Vec<usize> = (0..split).collect();
    order.sort_by(|&a, &b| keys[a].total_cmp(&keys[b]));
    order.extend(split..shape.len());
    order
}

/// All sizes of blocks, with those known to the compiler, and longer loops.
#[test]
fn products_and_solutions_are_the_dense_ones() {
    let small = [3, 4, 8]
        .map(|blocks| [0, 1, 5, 12].map(|border| (1..=10).map(move |block| shape(blocks, block, border))));
    let others = [
        shape(3, 4, 2),
        shape(20, 4, 2),
        shape(3, 3, 10),
        shape(11, 3, 15),
        shape(9, 6, 12),
        shape(30, 8, 12),
        shape(5, 10, 12),
    ];
    for (shape, seed) in small.into_iter().flatten().flatten().chain(others).zip(5..) {
        let mut lu = ArrowLu::new(shape);
        for (order, seed) in [(vec![], seed), (shuffled(shape, seed + 3), seed), (vec![], seed + 1)] {
            assert_like_dense(&mut lu, shape, &order, seed);
        }
    }
}

/// Sizes for which blocks are inverted by each of the two ways.
const BOTH_WAYS: [Shape; 2] = [shape(5, 2, 3), shape(5, 4, 2)];

#[test]
fn a_singular_block_is_named() {
    for shape in BOTH_WAYS {
        let singular = |change: &dyn Fn(&mut Arrow)| {
            let (mut arrow, _) = random(shape, &[], 1);
            change(&mut arrow);
            ArrowLu::new(shape).factor(&arrow).unwrap_err().block
        };
        assert_eq!(singular(&Arrow::clear), 1);
        // The name of the border with block 0 is the number of blocks.
        for row in 0..shape.len() {
            let block = row / shape.block;
            let named = if block == 0 {
                shape.blocks
            } else {
                block.min(shape.blocks)
            };
            assert_eq!(singular(&|arrow| arrow.set_unit_row(row, 0.0)), named, "row {row}");
            assert_eq!(singular(&|arrow| arrow.add(row, row, f64::NAN)), named, "row {row}");
        }
    }
}

#[test]
fn rows_are_replaced_and_added() {
    let shape = BOTH_WAYS[0];
    let (n, split) = (shape.len(), shape.blocks * shape.block);
    let (mut arrow, mut dense) = random(shape, &shuffled(shape, 7), 4);
    let added = numbers(n, 5);
    arrow.set_unit_row(3, 7.0);
    arrow.add_to_border_row(split + 1, added.iter().copied());
    arrow.add_row(split, split + 2, -2.0);
    for j in 0..n {
        dense[(3, j)] = if j == 3 { 7.0 } else { 0.0 };
        dense[(split, j)] -= 2.0 * dense[(split + 2, j)];
        dense[(split + 1, j)] += added[j];
    }
    let x = numbers(n, 9);
    let mut product = vec![0.0; n];
    arrow.multiply(&x, &mut product);
    assert!((DVector::from_vec(product) - &dense * DVector::from_vec(x)).amax() < 1e-12);
}

#[test]
#[should_panic(expected = "an entry in the band")]
fn entries_beyond_the_band_are_refused() {
    Arrow::new(BOTH_WAYS[0]).add(0, 5, 1.0);
}

#[test]
#[should_panic(expected = "an arrow matrix needs three blocks")]
fn two_blocks_are_refused() {
    let _ = Arrow::new(shape(2, 1, 0));
}

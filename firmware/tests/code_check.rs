//! Comparison of the code in RAM with its original: every bit of every word counts.

use firmware::code_check::{WORDS, are_equal, differs};

/// Number of calls after which a difference is found; `None` if there is none in twice as many as all words need.
fn found_after(copy: &[u32], original: &[u32]) -> Option<usize> {
    let mut place = 0;
    (0..2 * original.len().div_ceil(WORDS)).find(|_| differs(&mut place, copy, original))
}

#[test]
fn each_bit_of_each_word_is_compared_in_one_round() {
    let original: Vec<u32> = (0..10).map(|i| 0x0101_0101 * i).collect();
    assert_eq!(found_after(&original, &original), None);
    assert!(are_equal(&original, &original) && !are_equal(&original, &original[1..]));
    for (place, bit) in (0..10).flat_map(|place| (0..32).map(move |bit| (place, bit))) {
        let mut copy = original.clone();
        copy[place] ^= 1 << bit;
        assert_eq!(found_after(&copy, &original), Some(place / WORDS), "bit {bit} of word {place}");
        assert!(!are_equal(&copy, &original), "bit {bit} of word {place}");
    }
}

#[test]
fn copies_of_two_lengths_differ_and_no_code_is_equal_to_itself() {
    assert!(found_after(&[1, 2, 3], &[1, 2, 3, 4]).is_some() && found_after(&[1, 2, 3, 4], &[1, 2, 3]).is_some());
    let mut place = 0;
    assert!((0..3).all(|_| !differs(&mut place, &[], &[])) && place == 0);
}

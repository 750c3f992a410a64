//! Regions of the memory protection unit, decoded as the processor does (Arm DDI 0403, B3.5): they cover the code and nothing else.

use firmware::memory_protection::{BIT_ALIAS, GRAIN, Region, read_only};
use std::ops::Range;

/// Memory in which the code can be.
const RAM: Range<u32> = 0x2000_0000..0x2002_0000;

/// Ranges of the parts of a region that are on.
fn parts(region: Region) -> impl Iterator<Item = Range<u32>> {
    let Region { base, attributes } = region;
    assert_eq!(attributes & 1, 1, "a region that is off");
    let size = 2_u32 << ((attributes >> 1) & 0x1F);
    let begin = base & !0x1F;
    assert!(size >= 256 && begin % size == 0, "{size} bytes at {begin:x}: no region with parts");
    let off = (attributes >> 8) & 0xFF;
    (0..8)
        .filter(move |part| off >> part & 1 == 0)
        .map(move |part| begin + part * size / 8..begin + (part + 1) * size / 8)
}

#[test]
fn regions_cover_the_code_and_nothing_else() {
    let places = |from: u32| (from..=RAM.end).step_by(GRAIN as usize);
    for (start, end) in places(RAM.start).flat_map(|start| places(start + GRAIN).map(move |end| (start, end))) {
        let regions = read_only(start, end).unwrap();
        let used: Vec<_> = regions.iter().filter(|region| region.attributes != 0).collect();
        let (alias, code) = used.split_last().unwrap();
        let mut covered: Vec<_> = code.iter().flat_map(|&region| parts(*region)).collect();
        covered.sort_by_key(|part| part.start);
        assert_eq!((covered[0].start, covered.last().unwrap().end), (start, end), "{start:x}..{end:x}");
        assert!(covered.windows(2).all(|pair| pair[0].end == pair[1].start), "{start:x}..{end:x}: {covered:x?}");
        assert_eq!((alias.base & !0x1F, alias.attributes), (BIT_ALIAS, 0x1000_0031), "no access to 32 MiB of aliases");
        for (number, region) in (0..).zip(&regions) {
            assert_eq!((region.base >> 4 & 1, region.base & 0xF), (1, number), "each region has a number of its own");
        }
        for region in code {
            assert_eq!(region.attributes >> 24 & 7, 0b110, "read-only");
            assert_eq!(region.attributes >> 28 & 1, 0, "executable");
        }
    }
}

#[test]
fn a_range_that_no_regions_can_cover_has_none() {
    for (start, end) in
        [(0x2000_0000, 0x2000_0000), (0x2000_0100, 0x2000_0000), (0x2000_0004, 0x2000_0100), (0x2000_0000, 0x2000_0104)]
    {
        assert_eq!(read_only(start, end), None, "{start:x}..{end:x}");
    }
}

// What is drawn of each region: the arguments of two indexed indirect draws, one of its volume and
// one of its volume without the bottom cap; and which of its pieces are tested.
struct DrawArguments {
    index_count: atomic<u32>,
    instance_count: u32,
    first_index: atomic<u32>,
    base_vertex: i32,
    first_instance: u32,
};

@group(3) @binding(0) var<storage, read_write> draws: array<DrawArguments>;

// What becomes of a region: nothing; its whole volume; those of its pieces that are in view.
const LEFT_OUT: u32 = 0u;
const WHOLE: u32 = 1u;
const PIECES: u32 = 2u;

@group(3) @binding(3) var<storage, read_write> states: array<u32>;

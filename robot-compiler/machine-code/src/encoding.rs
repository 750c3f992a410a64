//! Encoding: the bytes of an instruction (Intel 64 Architectures Software Developer's Manual, volume 2, chapters 2.3 and 2.7).
//!
//! Memory is addressed relative to RDI, which points to the middle of the frame, so that displacements of one byte cover as much as possible.

use crate::Instructions;
use crate::registers::{Instruction, Operand, Operation};

/// Slot to which RDI points.
pub(crate) const MIDDLE: usize = 128;

/// Size of a slot, bytes: eight numbers.
const PLACE: i32 = 64;

/// VZEROUPPER, RET.
pub(crate) const END: [u8; 4] = [0xc5, 0xf8, 0x77, 0xc3];

/// Register number of RDI.
const RDI: u8 = 7;

/// Opcodes in the map of 0F: packed doubles with the prefix 66, one double with F2.
const LOAD: u8 = 0x10;
const STORE: u8 = 0x11;

const fn opcode(operation: Operation) -> u8 {
    match operation {
        Operation::Add => 0x58,
        Operation::Mul => 0x59,
        Operation::Sub => 0x5c,
        Operation::Div => 0x5e,
    }
}

/// Appends an instruction.
pub(crate) fn encode(bytes: &mut Vec<u8>, instruction: &Instruction, set: Instructions) {
    let (opcode, register, a, b) = match *instruction {
        // The middle operand's field must be zero if there is no such operand.
        Instruction::Load { to, from } => (LOAD, to, 0, Operand::Place(from)),
        Instruction::Store { to, from } => (STORE, from, 0, Operand::Place(to)),
        Instruction::Compute { operation, to, a, b } => (opcode(operation), to, a, b),
    };
    match set {
        Instructions::AvxOne => vex(bytes, opcode, register, a, b, 0b011),
        Instructions::Avx => vex(bytes, opcode, register, a, b, 0b101),
        Instructions::Avx512 => evex(bytes, opcode, register, a, b),
    }
}

/// Encoding for one number or for 256 bits: `C5 R.vvvv.L.pp` if the second operand has no high bit, otherwise `C4 RXB.mmmmm W.vvvv.L.pp`. `kind` is
/// `L.pp`: 0.11 for one number, 1.01 for four.
fn vex(bytes: &mut Vec<u8>, opcode: u8, register: u8, a: u8, b: Operand, kind: u8) {
    let not = |bit: u8| u8::from(bit == 0);
    let high = |register: u8| register >> 3 & 1;
    let last = (!a & 15) << 3 | kind;
    match b {
        Operand::Register(b) if high(b) == 1 => {
            bytes.extend([0xc4, not(high(register)) << 7 | 1 << 6 | 1, last, opcode, direct(register, b)]);
        }
        Operand::Register(b) => bytes.extend([0xc5, not(high(register)) << 7 | last, opcode, direct(register, b)]),
        Operand::Place(place) => {
            bytes.extend([0xc5, not(high(register)) << 7 | last, opcode]);
            let offset = (place as i32 - MIDDLE as i32) * PLACE;
            match i8::try_from(offset) {
                Ok(offset) => bytes.extend([near(register), offset as u8]),
                Err(_) => far(bytes, register, offset),
            }
        }
    }
}

/// Encoding for 512 bits: `62 RXBR'0.mmm W.vvvv.1.pp z.LL.b.V'.aaa`. A displacement of one byte is in units of vectors.
fn evex(bytes: &mut Vec<u8>, opcode: u8, register: u8, a: u8, b: Operand) {
    let not = |bit: u8| u8::from(bit & 1 == 0);
    // The second operand's bits 3 and 4 are B and X.
    let (x, b_high) = match b {
        Operand::Register(b) => (not(b >> 4), not(b >> 3)),
        Operand::Place(_) => (1, 1),
    };
    let first = not(register >> 3) << 7 | x << 6 | b_high << 5 | not(register >> 4) << 4 | 1;
    let second = 1 << 7 | (!a & 15) << 3 | 0b101;
    let third = 0b10 << 5 | not(a >> 4) << 3;
    bytes.extend([0x62, first, second, third, opcode]);
    match b {
        Operand::Register(b) => bytes.push(direct(register, b)),
        Operand::Place(place) => {
            let vectors = place as i32 - MIDDLE as i32;
            match i8::try_from(vectors) {
                Ok(vectors) => bytes.extend([near(register), vectors as u8]),
                Err(_) => far(bytes, register, vectors * PLACE),
            }
        }
    }
}

/// ModRM of two registers.
const fn direct(register: u8, b: u8) -> u8 {
    0b11 << 6 | (register & 7) << 3 | b & 7
}

/// ModRM of a register and of memory at RDI plus a displacement of one byte.
const fn near(register: u8) -> u8 {
    0b01 << 6 | (register & 7) << 3 | RDI
}

/// ModRM of a register and of memory at RDI plus a displacement of four bytes, followed by the displacement.
fn far(bytes: &mut Vec<u8>, register: u8, offset: i32) {
    bytes.push(0b10 << 6 | (register & 7) << 3 | RDI);
    bytes.extend(offset.to_le_bytes());
}

#[cfg(test)]
mod tests {
    use super::encode;
    use crate::Instructions;
    use crate::registers::{Instruction, Operand, Operation};

    fn bytes(instruction: Instruction, set: Instructions) -> Vec<u8> {
        let mut bytes = Vec::new();
        encode(&mut bytes, &instruction, set);
        bytes
    }

    const fn compute(operation: Operation, to: u8, a: u8, b: Operand) -> Instruction {
        Instruction::Compute { operation, to, a, b }
    }

    /// The bytes are those that GNU as 2.40 generates for the comment above them.
    #[test]
    fn instructions_have_the_bytes_that_an_assembler_gives_them() {
        use Instructions::{Avx, Avx512, AvxOne};
        use Operand::{Place, Register};
        use Operation::{Add, Div, Mul, Sub};
        let load = |to, from| Instruction::Load { to, from };
        let store = |to, from| Instruction::Store { to, from };
        let cases: [(Instruction, Instructions, &[u8]); 25] = [
            // vaddpd ymm1, ymm2, ymm3
            (compute(Add, 1, 2, Register(3)), Avx, &[0xc5, 0xed, 0x58, 0xcb]),
            // vsubpd ymm9, ymm10, ymm11
            (compute(Sub, 9, 10, Register(11)), Avx, &[0xc4, 0x41, 0x2d, 0x5c, 0xcb]),
            // vmulpd ymm9, ymm2, ymm11
            (compute(Mul, 9, 2, Register(11)), Avx, &[0xc4, 0x41, 0x6d, 0x59, 0xcb]),
            // vdivpd ymm1, ymm15, ymm7
            (compute(Div, 1, 15, Register(7)), Avx, &[0xc5, 0x85, 0x5e, 0xcf]),
            // vmovupd ymm1, [rdi-128]
            (load(1, 126), Avx, &[0xc5, 0xfd, 0x10, 0x4f, 0x80]),
            // vmovupd ymm12, [rdi+64]
            (load(12, 129), Avx, &[0xc5, 0x7d, 0x10, 0x67, 0x40]),
            // vmovupd ymm12, [rdi-8192]
            (load(12, 0), Avx, &[0xc5, 0x7d, 0x10, 0xa7, 0x00, 0xe0, 0xff, 0xff]),
            // vmovupd [rdi+8192], ymm8
            (store(256, 8), Avx, &[0xc5, 0x7d, 0x11, 0x87, 0x00, 0x20, 0x00, 0x00]),
            // vaddpd ymm8, ymm15, [rdi-192]
            (compute(Add, 8, 15, Place(125)), Avx, &[0xc5, 0x05, 0x58, 0x87, 0x40, 0xff, 0xff, 0xff]),
            // vaddsd xmm1, xmm2, xmm3
            (compute(Add, 1, 2, Register(3)), AvxOne, &[0xc5, 0xeb, 0x58, 0xcb]),
            // vsubsd xmm9, xmm10, xmm11
            (compute(Sub, 9, 10, Register(11)), AvxOne, &[0xc4, 0x41, 0x2b, 0x5c, 0xcb]),
            // vdivsd xmm1, xmm15, xmm7
            (compute(Div, 1, 15, Register(7)), AvxOne, &[0xc5, 0x83, 0x5e, 0xcf]),
            // vmovsd xmm1, [rdi-128]
            (load(1, 126), AvxOne, &[0xc5, 0xfb, 0x10, 0x4f, 0x80]),
            // vmovsd xmm12, [rdi-8192]
            (load(12, 0), AvxOne, &[0xc5, 0x7b, 0x10, 0xa7, 0x00, 0xe0, 0xff, 0xff]),
            // vmovsd [rdi+8192], xmm8
            (store(256, 8), AvxOne, &[0xc5, 0x7b, 0x11, 0x87, 0x00, 0x20, 0x00, 0x00]),
            // vmulsd xmm8, xmm15, [rdi-192]
            (compute(Mul, 8, 15, Place(125)), AvxOne, &[0xc5, 0x03, 0x59, 0x87, 0x40, 0xff, 0xff, 0xff]),
            // vaddpd zmm1, zmm2, zmm3
            (compute(Add, 1, 2, Register(3)), Avx512, &[0x62, 0xf1, 0xed, 0x48, 0x58, 0xcb]),
            // vsubpd zmm9, zmm18, zmm27
            (compute(Sub, 9, 18, Register(27)), Avx512, &[0x62, 0x11, 0xed, 0x40, 0x5c, 0xcb]),
            // vmulpd zmm25, zmm10, zmm11
            (compute(Mul, 25, 10, Register(11)), Avx512, &[0x62, 0x41, 0xad, 0x48, 0x59, 0xcb]),
            // vdivpd zmm17, zmm31, zmm23
            (compute(Div, 17, 31, Register(23)), Avx512, &[0x62, 0xa1, 0x85, 0x40, 0x5e, 0xcf]),
            // vmovupd zmm1, [rdi-8192]
            (load(1, 0), Avx512, &[0x62, 0xf1, 0xfd, 0x48, 0x10, 0x4f, 0x80]),
            // vmovupd zmm28, [rdi+8128]
            (load(28, 255), Avx512, &[0x62, 0x61, 0xfd, 0x48, 0x10, 0x67, 0x7f]),
            // vmovupd zmm12, [rdi+8192]
            (load(12, 256), Avx512, &[0x62, 0x71, 0xfd, 0x48, 0x10, 0xa7, 0x00, 0x20, 0x00, 0x00]),
            // vmovupd [rdi+64], zmm20
            (store(129, 20), Avx512, &[0x62, 0xe1, 0xfd, 0x48, 0x11, 0x67, 0x01]),
            // vaddpd zmm8, zmm31, [rdi-64]
            (compute(Add, 8, 31, Place(127)), Avx512, &[0x62, 0x71, 0x85, 0x40, 0x58, 0x47, 0xff]),
        ];
        for (instruction, set, wanted) in cases {
            assert_eq!(bytes(instruction, set), wanted, "{instruction:?} {set:?}");
        }
    }
}

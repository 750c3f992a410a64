// Every function has turns in r0 and the words' address in r1, and leaves all registers alone but r0 to r3, r12 and the lower
// half of the float registers, as the calling convention wants.
.syntax unified
.thumb

.macro start name, place
.global micro_\name\()_\place
.type micro_\name\()_\place, %function
.balignw 64, 0xbf00
.thumb_func
micro_\name\()_\place:
.pushsection .rodata.micro_names, "a", %progbits
8:  .ascii "\name\()_\place"
9:  .popsection
.pushsection .rodata.micro_table, "a", %progbits
.word micro_\name\()_\place
.word 8b
.word 9b - 8b
.popsection
.endm

// One copy: registers, the loop at its alignment, the return. Loops may be longer than a narrow branch reaches.
.macro copy name, place, shift
start \name, \place
mov r3, r1
str r1, [r1]
mov r12, #0
ldr r2, =MICRO_CONSTANTS
vmov.f32 s0, #1.0
vmov.f32 s1, #1.0
vmov.f32 s2, #1.0
vmov.f32 s3, #1.0
vmov.f32 s4, #1.0
vmov.f32 s5, #1.0
vmov.f32 s6, #1.0
vmov.f32 s7, #1.0
.balignw 16, 0xbf00
.if \shift
nop
.endif
1:
body_\name
subs r0, r0, #1
bne.w 1b
bx lr
.ltorg
.size micro_\name\()_\place, . - micro_\name\()_\place
.endm

.macro stretch name
.section .text.micro, "ax", %progbits
copy \name, flash, 0
copy \name, flash2, 1
.section .data.micro, "aw", %progbits
copy \name, sram, 0
.endm

.section .rodata.micro_table, "a", %progbits
.balign 4
.global MICRO_TABLE
MICRO_TABLE:

// 128 lines of flash, 16 times as many as the data cache has.
.section .rodata.micro_constants, "a", %progbits
.balign 16
.global MICRO_CONSTANTS
MICRO_CONSTANTS:
.fill 512, 4, 0x3f800000

.section .text.micro, "ax", %progbits
start nothing, flash
bx lr
.size micro_nothing_flash, . - micro_nothing_flash

.macro body_loop
.endm
stretch loop

.macro body_nop
.rept 16
nop
.endr
.endm
stretch nop

.macro body_wide
.rept 16
add.w r3, r3, r12
.endr
.endm
stretch wide

// 640 bytes, which the instruction cache holds, and 2 KiB, which it does not.
.macro body_wide_cached
.rept 160
add.w r3, r3, r12
.endr
.endm
stretch wide_cached

.macro body_wide_uncached
.rept 512
add.w r3, r3, r12
.endr
.endm
stretch wide_uncached

.macro body_vldr
.irp n, 0, 1, 2, 3, 4, 5, 6, 7, 0, 1, 2, 3, 4, 5, 6, 7
vldr s\n, [r1, #4 * \n]
.endr
.endm
stretch vldr

.macro body_vldr_double
.rept 16
vldr d0, [r1]
.endr
.endm
stretch vldr_double

.macro body_vldr_used
.rept 8
vldr s0, [r1]
vadd.f32 s1, s0, s2
.endr
.endm
stretch vldr_used

.macro body_vldr_beside_ldr
.rept 8
vldr s0, [r1]
ldr r12, [r1, #4]
.endr
.endm
stretch vldr_beside_ldr

.macro body_vldr_beside_add
.rept 8
vldr s0, [r1]
add.w r3, r3, r12
.endr
.endm
stretch vldr_beside_add

.macro body_vldr_literal
.rept 16
vldr s0, 7f
.endr
b 6f
.balign 4
7:  .word 0x3f800000
6:
.endm
stretch vldr_literal

.macro body_vstr
.irp n, 0, 1, 2, 3, 4, 5, 6, 7, 0, 1, 2, 3, 4, 5, 6, 7
vstr s\n, [r1, #4 * \n]
.endr
.endm
stretch vstr

.macro body_vstr_behind_vldr
.rept 8
vldr s0, [r1]
vstr s1, [r1, #4]
.endr
.endm
stretch vstr_behind_vldr

.macro body_vldm
.rept 8
vldm r1, {s0-s3}
.endr
.endm
stretch vldm

.macro body_vmov_to_float
.rept 16
vmov s0, r3
.endr
.endm
stretch vmov_to_float

.macro body_vmov_to_core
.rept 16
vmov r3, s0
.endr
.endm
stretch vmov_to_core

.macro body_vmov_two_to_float
.rept 16
vmov s0, s1, r3, r12
.endr
.endm
stretch vmov_two_to_float

.macro body_vmov_two_to_core
.rept 16
vmov r3, r12, s0, s1
.endr
.endm
stretch vmov_two_to_core

.macro body_vadd
.irp n, 0, 1, 2, 3, 4, 5, 0, 1, 2, 3, 4, 5, 0, 1, 2, 3
vadd.f32 s\n, s6, s7
.endr
.endm
stretch vadd

.macro body_vadd_chain
.rept 16
vadd.f32 s0, s0, s7
.endr
.endm
stretch vadd_chain

.macro body_vmla
.irp n, 0, 1, 2, 3, 4, 5, 0, 1, 2, 3, 4, 5, 0, 1, 2, 3
vmla.f32 s\n, s6, s7
.endr
.endm
stretch vmla

.macro body_vmla_addend
.rept 16
vmla.f32 s0, s6, s7
.endr
.endm
stretch vmla_addend

.macro body_vmla_factor
.rept 8
vmla.f32 s0, s1, s7
vmla.f32 s1, s0, s7
.endr
.endm
stretch vmla_factor

.macro body_vmla_beside_add
.rept 8
vmla.f32 s0, s6, s7
add.w r3, r3, r12
add.w r3, r3, r12
.endr
.endm
stretch vmla_beside_add

.macro body_vmul_vadd
.rept 8
vmul.f32 s0, s6, s7
vadd.f32 s1, s1, s0
.endr
.endm
stretch vmul_vadd

.macro body_vmul_vadd_apart
.rept 4
vmul.f32 s0, s6, s7
vmul.f32 s1, s6, s7
vadd.f32 s2, s2, s0
vadd.f32 s3, s3, s1
.endr
.endm
stretch vmul_vadd_apart

.macro body_vdiv
.rept 4
vdiv.f32 s0, s6, s7
.endr
.endm
stretch vdiv

.macro body_vdiv_beside_add
.rept 4
vdiv.f32 s0, s6, s7
.rept 12
add.w r3, r3, r12
.endr
.endr
.endm
stretch vdiv_beside_add

.macro body_vsqrt
.rept 4
vsqrt.f32 s0, s7
.endr
.endm
stretch vsqrt

.macro body_vsqrt_beside_add
.rept 4
vsqrt.f32 s0, s7
.rept 12
add.w r3, r3, r12
.endr
.endr
.endm
stretch vsqrt_beside_add

.macro body_sdiv
mvn r3, #0x80000000
mov r12, #3
.rept 8
sdiv r2, r3, r12
.endr
.endm
stretch sdiv

.macro body_ldr
.rept 8
ldr r12, [r1, #4]
nop
.endr
.endm
stretch ldr

.macro body_ldr_chain
.rept 16
ldr r3, [r3]
.endr
.endm
stretch ldr_chain

.macro body_ldr_pairs
.rept 8
ldr r12, [r1, #4]
ldr r3, [r1, #8]
nop
.endr
.endm
stretch ldr_pairs

.macro body_str
.rept 16
str r3, [r1, #4]
.endr
.endm
stretch str

.macro body_str_behind_ldr
.rept 8
ldr r12, [r1, #4]
str r3, [r1, #8]
.endr
.endm
stretch str_behind_ldr

.macro body_ldm
.rept 8
ldm r1, {r3, r12}
.endr
.endm
stretch ldm

.macro body_ldm_behind_stm
.rept 8
stm r1, {r3, r12}
ldm r1, {r3, r12}
.endr
.endm
stretch ldm_behind_stm

.macro body_address_from_sum
.rept 8
adds.w r3, r1, #4
ldr r12, [r3]
.endr
.endm
stretch address_from_sum

// To a wide instruction at the start of a word; two bytes on, it straddles words.
.macro body_branch
.rept 8
b.n 7f
nop
7:  add.w r3, r3, r12
.endr
.endm
stretch branch

// To a narrow instruction at the start of a word, or in its second half.
.macro body_branch_narrow
.rept 8
b.n 7f
nop
7:  nop
nop
.endr
.endm
stretch branch_narrow

.macro body_branch_taken
cmp r0, r0
.rept 8
beq.n 7f
nop
7:  add.w r3, r3, r12
.endr
.endm
stretch branch_taken

.macro body_it_behind_narrow
cmp r0, r0
.rept 8
nop
it eq
moveq r12, r3
.endr
.endm
stretch it_behind_narrow

.macro body_it_behind_wide
cmp r0, r0
.rept 8
add.w r3, r3, #0
it eq
moveq r12, r3
.endr
.endm
stretch it_behind_wide

// A table in flash through a pointer: a line for each load, more than the data cache holds; then the same line.
.macro body_table
.irp n, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15
ldr r12, [r2, #16 * \n]
nop
.endr
.endm
stretch table

.macro body_table_cached
.rept 16
ldr r12, [r2]
nop
.endr
.endm
stretch table_cached

.section .rodata.micro_table, "a", %progbits
7:
.section .rodata.micro_rows, "a", %progbits
.balign 4
.global MICRO_ROWS
MICRO_ROWS:
.word (7b - MICRO_TABLE) / 12

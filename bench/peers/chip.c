/* Counts the instructions of contestants on an emulated STM32F405 and prints them, with their torques, over semihosting.
 *
 * The emulator takes 1 ns for an instruction (-icount shift=0) and timer 2 counts at 1 GHz, so its count is instructions.
 * A line is
 *
 *     NAME INSTRUCTIONS... / TORQUES...
 *
 * one count a state, less that of a call of a function that does nothing, and the bits of the torques in hexadecimal.
 */
#include "chip.h"
#include <stdint.h>
#include <string.h>

/* CONTESTANTS is a list of X(name), from the command line. */
#define X(name) contestant name;
CONTESTANTS
#undef X

static const struct {
    const char *name;
    contestant *run;
} contestants[] = {
#define X(name) {#name, name},
    CONTESTANTS
#undef X
};

#define REGISTER(address) (*(volatile uint32_t *)(address))
#define RCC_APB1ENR REGISTER(0x40023840)
#define TIM2_CR1 REGISTER(0x40000000)
#define TIM2_EGR REGISTER(0x40000014)
#define TIM2_CNT REGISTER(0x40000024)
#define TIM2_PSC REGISTER(0x40000028)
#define TIM2_ARR REGISTER(0x4000002c)
#define CPACR REGISTER(0xe000ed88)

static struct state states[STATES];
static uint32_t counts[STATES];
static float torques[STATES][JOINTS];

static __attribute__((noinline)) void nothing(struct state *state, float *torques) {
    __asm__ volatile("" : : "r"(state), "r"(torques) : "memory");
}

/* The estimate of cycles finds calls by this function's name. */
static __attribute__((noinline)) uint32_t counted_call(contestant *run, struct state *state, float *torques) {
    uint32_t begin = TIM2_CNT;
    run(state, torques);
    return TIM2_CNT - begin;
}

static void semihost(int operation, const void *argument) {
    register int r0 __asm__("r0") = operation;
    register const void *r1 __asm__("r1") = argument;
    __asm__ volatile("bkpt 0xab" : "+r"(r0) : "r"(r1) : "memory");
}

static void print(const char *text) { semihost(4, text); }

static void print_number(uint32_t number, uint32_t base, const char *before) {
    char text[12], *at = text + sizeof text;
    *--at = 0;
    do {
        *--at = "0123456789abcdef"[number % base];
        number /= base;
    } while (number);
    print(before);
    print(at);
}

int main(void) {
    RCC_APB1ENR |= 1;
    TIM2_PSC = 0;
    TIM2_ARR = 0xffffffff;
    TIM2_EGR = 1;
    TIM2_CR1 = 1;

    bench_chip_states(states);
    for (unsigned c = 0; c < sizeof contestants / sizeof *contestants; ++c) {
        for (unsigned i = 0; i < STATES; ++i) {
            uint32_t empty = counted_call(nothing, &states[i], torques[i]);
            counts[i] = counted_call(contestants[c].run, &states[i], torques[i]) - empty;
        }
        print(contestants[c].name);
        for (unsigned i = 0; i < STATES; ++i)
            print_number(counts[i], 10, " ");
        print(" /");
        for (unsigned i = 0; i < STATES; ++i)
            for (unsigned j = 0; j < JOINTS; ++j) {
                uint32_t bits;
                memcpy(&bits, &torques[i][j], sizeof bits);
                print_number(bits, 16, " ");
            }
        print("\n");
    }
    /* ADP_Stopped_ApplicationExit */
    semihost(0x18, (const void *)0x20026);
    for (;;) {
    }
}

extern uint32_t stack_end, data_load, data_begin, data_end, bss_begin, bss_end;

void reset(void) {
    CPACR |= 0xf << 20; /* the floating-point unit */
    __asm__ volatile("dsb\n isb");
    memcpy(&data_begin, &data_load, (char *)&data_end - (char *)&data_begin);
    memset(&bss_begin, 0, (char *)&bss_end - (char *)&bss_begin);
    main();
}

/* A fault stops the emulator with an error: nothing that follows it could be believed. */
static void fault(void) {
    print("fault\n");
    semihost(0x18, (const void *)0x20023);
    for (;;) {
    }
}

__attribute__((section(".vectors"), used)) static const void *const vectors[] = {
    &stack_end, reset, fault, fault, fault, fault, fault,
};

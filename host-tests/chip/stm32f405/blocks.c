/* Time as the processor spends it: called by Unicorn before each block of instructions, a million times a second, which in
   Python would take longer than all else. `blocks.py` builds it, and has the same structures. */

#include <stddef.h>
#include <stdint.h>

/* What blocks take, once they were measured. More than the image has. */
#define SLOTS 65536

typedef struct {
    /* Address and size; 0: free. */
    uint64_t key;
    double cycles;
    /* Whether an exception that waits may be taken behind it. */
    int32_t unmasks;
} Block;

typedef struct {
    /* s, s, s */
    double now, next_at, stalled_until;
    double cycles, core_hz;
    /* Whether an exception may be taken before the next block. */
    int32_t looks;
    /* Python's: looks whether the emulation has to stop here; stops it, and says so. */
    int32_t (*attend)(void);
    /* Python's: what a block takes, and whether it unmasks. */
    int32_t (*measure)(uint64_t address, uint32_t size, double *cycles);
    Block blocks[SLOTS];
} Time;

size_t time_bytes(void) { return sizeof(Time); }

void on_block(void *uc, uint64_t address, uint32_t size, void *context) {
    Time *time = context;
    uint64_t key = address << 16 | size;
    uint32_t slot = (uint32_t)(address >> 1) % SLOTS;
    Block measured = {key, 0.0, 0};
    Block *block = &measured;
    (void)uc;
    if ((time->stalled_until > time->now || time->next_at <= time->now || time->looks) && time->attend()) {
        return;
    }
    for (uint32_t tries = 0; tries < 16; tries++, slot = (slot + 1) % SLOTS) {
        if (time->blocks[slot].key == key) {
            block = &time->blocks[slot];
            break;
        }
        if (time->blocks[slot].key == 0) {
            block = &time->blocks[slot];
            *block = measured;
            break;
        }
    }
    if (block->cycles == 0.0) {
        block->unmasks = time->measure(address, size, &block->cycles);
    }
    time->looks = block->unmasks;
    time->cycles += block->cycles;
    time->now += block->cycles / time->core_hz;
}

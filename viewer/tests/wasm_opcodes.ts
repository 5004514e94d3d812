// Opcodes of the vector instructions of a WebAssembly module (WebAssembly Core Specification 2.0, 5.4).

const CODE_SECTION = 10;
const VECTOR_PREFIX = 0xfd;
const OTHER_PREFIX = 0xfc;

/** Immediates of an instruction: numbers of 7 bits a byte, then plain bytes. */
type Immediates = readonly [numbers: number, bytes: number];
const NONE: Immediates = [0, 0];
/** Alignment and offset of an access to memory. */
const ADDRESS: Immediates = [2, 0];

class Reader {
  constructor(
    private readonly bytes: Uint8Array,
    public at: number,
  ) {}

  byte(): number {
    this.at += 1;
    return this.bytes[this.at - 1];
  }

  number(): number {
    let [value, shift] = [0, 0];
    for (;;) {
      const byte = this.byte();
      value += (byte & 0x7f) * 2 ** shift;
      shift += 7;
      if (byte < 0x80) {
        return value;
      }
    }
  }

  skip([numbers, bytes]: Immediates): void {
    for (let left = numbers; left > 0; left -= 1) {
      this.number();
    }
    this.at += bytes;
  }
}

function immediatesOf(opcode: number): Immediates {
  const isAddress = opcode >= 0x28 && opcode <= 0x3e;
  const hasNumber =
    // Blocks, branches, calls, variables, tables, sizes of memory, integers, references.
    [0x02, 0x03, 0x04, 0x0c, 0x0d, 0x10, 0x12, 0x3f, 0x40, 0x41, 0x42, 0xd0, 0xd2].includes(opcode) ||
    (opcode >= 0x20 && opcode <= 0x26);
  switch (opcode) {
    case 0x11:
      return [2, 0];
    case 0x43:
      return [0, 4];
    case 0x44:
      return [0, 8];
    default:
      return isAddress ? ADDRESS : hasNumber ? [1, 0] : NONE;
  }
}

function otherImmediatesOf(opcode: number): Immediates {
  if (opcode < 8) {
    return NONE;
  }
  return [8, 10, 12, 14].includes(opcode) ? [2, 0] : [1, 0];
}

function vectorImmediatesOf(opcode: number): Immediates {
  if (opcode <= 0x0b || opcode === 0x5c || opcode === 0x5d) {
    return ADDRESS;
  }
  if (opcode === 0x0c || opcode === 0x0d) {
    return [0, 16];
  }
  if (opcode >= 0x15 && opcode <= 0x22) {
    return [0, 1];
  }
  return opcode >= 0x54 && opcode <= 0x5b ? [2, 1] : NONE;
}

function readBody(reader: Reader, found: Set<number>): void {
  const end = reader.number() + reader.at;
  for (let locals = reader.number(); locals > 0; locals -= 1) {
    reader.skip([1, 1]);
  }
  while (reader.at < end) {
    const opcode = reader.byte();
    if (opcode === VECTOR_PREFIX) {
      const vector = reader.number();
      found.add(vector);
      reader.skip(vectorImmediatesOf(vector));
    } else if (opcode === OTHER_PREFIX) {
      reader.skip(otherImmediatesOf(reader.number()));
    } else if (opcode === 0x0e || opcode === 0x1c) {
      // A table of branches has one more, the types of a selection are plain.
      reader.skip([reader.number() + (opcode === 0x0e ? 1 : 0), 0]);
    } else {
      reader.skip(immediatesOf(opcode));
    }
  }
  if (reader.at !== end) {
    throw new Error(`a function ends at byte ${end}, its instructions at ${reader.at}`);
  }
}

/** The opcodes of all vector instructions of a module. */
export function vectorOpcodes(module: Uint8Array): Set<number> {
  const found = new Set<number>();
  const reader = new Reader(module, 8);
  while (reader.at < module.length) {
    const id = reader.byte();
    const size = reader.number();
    const end = reader.at + size;
    for (let left = id === CODE_SECTION ? reader.number() : 0; left > 0; left -= 1) {
      readBody(reader, found);
    }
    reader.at = end;
  }
  return found;
}

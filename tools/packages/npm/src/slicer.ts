// The engine as WebAssembly, by the calls of core.cpp: one mesh after the other, on this thread. All lengths are in mm.
export type ErrorCode =
    | "invalid_argument" | "malformed_mesh" | "empty_mesh" | "bad_coordinate" | "bad_planes" | "result_too_large" | "out_of_memory" | "cancelled" | "lost";
/** One line for a person. `lost`: the engine ended, or the worker in which it ran. Load another; a pool does so by itself. */
export class SliceError extends Error {
    constructor(
        readonly code: ErrorCode,
        message: string,
    ) {
        super(message.replace(/\s+/g, " "));
    }
}
/** @internal */
export const fail = (code: ErrorCode, message: string): never => {
    throw new SliceError(code, message);
};

/** Triangles: nine numbers each, or three indices each to vertices of three numbers; counter-clockwise as seen from outside. */
export interface Mesh {
    readonly positions: Float32Array | Float64Array;
    readonly indices?: Uint32Array | Uint16Array | null | undefined;
    /** Of the positions (1). */
    readonly mmPerUnit?: number | undefined;
}

const fillRules = ["contours", "even-odd", "non-zero", "positive", "outermost"] as const;
const roles = ["outer", "hole", "flat", "open"] as const;
export interface SliceOptions {
    /** Height of uniform layers (0.2). */
    readonly layerHeight?: number;
    /** Height of the first plane above the mesh's lowest vertex (half a layer). */
    readonly firstHeight?: number;
    /** Planes at these heights instead. */
    readonly heights?: Iterable<number>;
    /** A range of the layers, as they are in the whole; the end is one past the last. */
    readonly firstLayer?: number;
    readonly endLayer?: number;
    /** Join ends of open polylines at most so far apart (auto: a hundredth of the mesh's diagonal). */
    readonly stitch?: number | "auto";
    /** What is solid where contours overlap (non-zero: they are united). */
    readonly fillRule?: (typeof fillRules)[number];
    /** Fill gaps narrower than twice this (0). */
    readonly closing?: number;
    /** Grow what is solid by so much, or shrink it where negative (0). */
    readonly offset?: number;
    /** Drop points that lie within so much of the lines left (0). */
    readonly simplify?: number;
    /** Step of the integer grid (2 ** -20, doubled until the mesh fits). */
    readonly grid?: number;
}

/// As in the engine's options/counters.inc, behind the grid.
const counted = [
    "grid", "triangles", "degenerate", "crossed", "layers", "segments", "contours", "points", "stitches", "holes", "openContours", "flatContours",
    "overruledContours", "wouldCloseContours", "emptiedLayers", "cancelledLayers", "firstLayer", "plannedLayers",
] as const;
/** The step of the integer grid, and how much there is of the others. */
export type SliceInfo = Readonly<Record<(typeof counted)[number], number>>;
/// The arrays of a result: lamella_layer, lamella_contour and lamella_point of lamella.h.
export type Flat = { hash: string; info: SliceInfo; layers: ArrayBuffer; contours: ArrayBuffer; points: ArrayBuffer };

export class Contour {
    constructor(
        /** Outer contours run counter-clockwise, holes clockwise; open ones are polylines, where the mesh lacks faces. */
        readonly role: (typeof roles)[number],
        /** Index in the layer of the contour around it, or -1. */
        readonly parent: number,
        /** Positive for an outer contour, negative for a hole, else 0. */
        readonly area: number,
        /** x and y of each point in steps of the grid, exact; the first is not repeated. */
        readonly gridPoints: Int32Array,
        readonly grid: number,
    ) {}
    /** x and y of each point. */
    get points(): Float64Array {
        return Float64Array.from(this.gridPoints, (at) => at * this.grid);
    }
    get length(): number {
        const points = this.points;
        const step = (to: number, from: number) => Math.hypot(points[to]! - points[from]!, points[to + 1]! - points[from + 1]!);
        let sum = this.role === "open" ? 0 : step(0, points.length - 2);
        for (let i = 2; i < points.length; i += 2) {
            sum += step(i, i - 2);
        }
        return sum;
    }
}
export interface Layer {
    readonly z: number;
    readonly bottom: number;
    readonly top: number;
    /** Less holes; NaN, not known, where a contour is open. */
    readonly area: number;
    /** Each outer contour is followed by its holes. */
    readonly contours: readonly Contour[];
}
export class SliceResult {
    #layers: readonly Layer[] | undefined;
    /** @internal */
    constructor(readonly flat: Flat) {}
    /** That of `lamella slice --hash`. */
    get hash(): string {
        return this.flat.hash;
    }
    get info(): SliceInfo {
        return this.flat.info;
    }
    get layers(): readonly Layer[] {
        return (this.#layers ??= layersOf(this.flat));
    }
}

/// A layer is seven words of 8 bytes, a contour six.
function layersOf({ info: { grid, layers }, ...flat }: Flat): Layer[] {
    const heights = new Float64Array(flat.layers), counts = new BigInt64Array(flat.layers);
    const words = new BigInt64Array(flat.contours), points = new Int32Array(flat.points);
    const areaOf = (twice: bigint) => (Number(twice) / 2) * grid * grid;
    return Array.from({ length: layers }, (_, layer) => {
        const at = 7 * layer, first = Number(counts[at + 3]), twice: bigint[] = [];
        const contours = Array.from({ length: Number(counts[at + 4]) }, (_, i) => {
            const word = (which: number) => words[6 * (first + i) + which]!;
            const from = 2 * Number(word(0)), own = points.subarray(from, from + 2 * Number(BigInt.asUintN(32, word(4))));
            twice.push((word(2) << 64n) | BigInt.asUintN(64, word(1)));
            const parent = word(3) < 0 ? -1 : Number(word(3)) - first;
            return new Contour(roles[Number(word(5) & 3n)]!, parent, areaOf(twice[i]!), own, grid);
        });
        const area = contours.some(({ role }) => role === "open") ? NaN : areaOf(twice.reduce((sum, one) => sum + one, 0n));
        return { z: heights[at + 1]!, bottom: heights[at]!, top: heights[at + 2]!, area, contours };
    });
}

/** lamella.wasm: where it lies, its bytes, or compiled. */
export type Source = URL | BufferSource | WebAssembly.Module;
type Core = { memory: WebAssembly.Memory } & Record<"_initialize" | "malloc" | "free" | "slice" | "found", (...values: number[]) => number>;
/** Of node; bundlers leave it alone. @internal */
export const node = (name: string) => import(/* webpackIgnore: true */ /* @vite-ignore */ `node:${name}`);

/** @internal */
export async function compile(source: Source = new URL("./lamella.wasm", import.meta.url)): Promise<WebAssembly.Module> {
    const read = async (at: URL) => {
        if (at.protocol === "file:") {
            return (await node("fs/promises")).readFile(at); // node's fetch() reads no files
        }
        const answer = await fetch(at);
        return answer.ok ? answer.arrayBuffer() : fail("lost", `${at}: ${answer.status} ${answer.statusText}`);
    };
    return source instanceof WebAssembly.Module ? source : WebAssembly.compile(source instanceof URL ? await read(source) : source);
}

/** Refuses what is no mesh. @internal */
export function checked({ positions, indices, mmPerUnit = 1 }: Mesh) {
    const wrong =
        !/^Float(32|64)Array$/.test(positions?.constructor.name) ? "positions are no Float32Array or Float64Array"
        : indices && !/^Uint(16|32)Array$/.test(indices.constructor.name) ? "indices are no Uint16Array or Uint32Array"
        : positions.length % (indices ? 3 : 9) !== 0 ? `there are ${positions.length} numbers in positions, not a multiple of ${indices ? 3 : 9}`
        : indices && indices.length % 3 !== 0 ? `there are ${indices.length} indices, not a multiple of 3` : "";
    return wrong ? fail("malformed_mesh", wrong) : { positions, indices, mmPerUnit };
}

/** A number for each option, NaN where none is given, and then the heights. */
function numbersOf({ heights = [], ...options }: SliceOptions): Float64Array {
    const numbers: Record<string, number> = {
        layerHeight: NaN, firstHeight: NaN, firstLayer: NaN, endLayer: NaN, stitch: -1, fillRule: 2, closing: NaN, offset: NaN, simplify: NaN, grid: NaN,
    };
    for (const [name, value] of Object.entries(options).filter(([, value]) => value !== undefined)) {
        const number = value === "auto" ? -1 : name === "fillRule" ? fillRules.indexOf(value as never) : Number(value);
        const least = /Rule|Layer/.test(name) ? 0 : -Infinity;
        const most = /Layer/.test(name) ? 2 ** 53 : Infinity;
        numbers[name] = name in numbers && number >= least ? Math.min(number, most) : fail("invalid_argument", `no option ${name} can be ${value}`);
    }
    const list = Symbol.iterator in Object(heights) ? heights : fail("invalid_argument", "heights are no list of numbers");
    return Float64Array.from([...Object.values(numbers), ...list]);
}

export class Slicer {
    #core: Core | undefined;
    private constructor(core: Core) { this.#core = core; }

    static async load(source?: Source): Promise<Slicer> {
        const imports = {
            env: {
                emscripten_notify_memory_growth() {},
                lamella_write_decimal(value: number, at: number): number {
                    const text = `${value}`.length < 24 ? `${value}` : value.toExponential(); // in at most 23 characters
                    return new TextEncoder().encodeInto(text, new Uint8Array(core.memory.buffer, at >>> 0)).written;
                },
            },
            wasi_snapshot_preview1: {
                clock_time_get(_clock: number, _precision: bigint, at: number): number {
                    new DataView(core.memory.buffer).setBigUint64(at >>> 0, BigInt(Math.round(1e6 * performance.now())), true); // ns
                    return 0;
                },
                proc_exit: () => fail("lost", "the engine aborted"),
            },
        };
        const core = (await WebAssembly.instantiate(await compile(source), imports)).exports as unknown as Core;
        core._initialize();
        return new Slicer(core);
    }

    /** Throws a SliceError, or what the engine died of. The result is a copy: nothing is to be freed. */
    slice(mesh: Mesh, options: SliceOptions = {}): SliceResult {
        const core = this.#core ?? fail("lost", "the engine ended in an earlier call");
        const numbers = numbersOf(options), { positions, indices, mmPerUnit } = checked(mesh);
        const given = [numbers, positions, Uint32Array.from(indices ?? [])];
        const bytes = given.reduce((sum, array) => sum + array.byteLength, 0);
        const at = (bytes < 2 ** 32 && core.malloc(bytes) >>> 0) || fail("out_of_memory", `no memory for a mesh of ${bytes} bytes`);
        const vertices = at + numbers.byteLength, corners = vertices + positions.byteLength;
        given.forEach(({ buffer, byteOffset, byteLength }, i) => {
            new Uint8Array(core.memory.buffer).set(new Uint8Array(buffer, byteOffset, byteLength), [at, vertices, corners][i]);
        });
        const heights = options.heights ? numbers.length - 10 : -1, type = positions.BYTES_PER_ELEMENT / 4 - 1;
        const triangles = indices ? indices.length / 3 : positions.length / 9;
        this.#core = undefined; // for good, if the call does not return
        const error = core.slice(at, heights, vertices, positions.length / 3, type, indices ? corners : 0, triangles, mmPerUnit) >>> 0;
        this.#core = core;
        core.free(at);
        return error === 0 ? resultOf(core) : failAs(core, error);
    }
}

/// The code and the message that stand there; options have their names of C++.
function failAs(core: Core, at: number): never {
    const said = new Uint8Array(core.memory.buffer, at);
    const [code, ...words] = new TextDecoder().decode(said.slice(0, said.indexOf(0))).split(" ");
    const camel = (name: string) => name.replace(/_mm$/, "").replace(/_./g, (part) => part[1]!.toUpperCase());
    return fail(code as ErrorCode, words.join(" ").replace(/\b[a-z]+(_[a-z]+)+\b/g, camel));
}

function resultOf(core: Core): SliceResult {
    const [layers, contours, points, high, low, ...counts] = new Float64Array(core.memory.buffer, core.found() >>> 0, 5 + counted.length) as unknown as number[];
    const info = Object.fromEntries(counted.map((name, i) => [name, counts[i]])) as SliceInfo;
    const copy = (from: number, bytes: number) => core.memory.buffer.slice(from, from + bytes) as ArrayBuffer;
    return new SliceResult({
        hash: [high!, low!].map((half) => half.toString(16).padStart(8, "0")).join(""),
        info,
        layers: copy(layers!, 56 * info.layers),
        contours: copy(contours!, 48 * info.contours),
        points: copy(points!, 8 * info.points),
    });
}

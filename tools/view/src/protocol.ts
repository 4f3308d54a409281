// What the page and its worker say to one another. `seq` numbers questions about a layer, `generation` meshes and plans: an answer
// to an older one is dropped.

export const rules = ["contours", "even-odd", "non-zero", "positive", "outermost"] as const;
export const gzip = "application/gzip"; // type of a mesh that `lamella view` has put into the page
export const roles = ["outer", "hole", "flat", "open"] as const;

/// Lengths in mm. stitch -1: by the mesh's size; cusp 0: uniform layers.
export interface Plan {
    height: number;
    cusp: number;
    stitch: number;
    closing: number;
    rule: number;
}

export interface MeshInfo {
    format: string;
    triangles: number;
    mm_per_unit: number;
    states_unit: boolean;
    min: [number, number, number];
    max: [number, number, number];
    parts: string[];
    warnings: string[];
}

export type Question =
    | { ask: "boot"; module: WebAssembly.Module }
    | { ask: "open"; generation: number; file: Blob; name: string; unit: number }
    | { ask: "plan"; generation: number; plan: Plan }
    | { ask: "layer"; seq: number; index: number; pixel: number }
    | { ask: "below"; seq: number; index: number; degrees: number; pixel: number }
    | { ask: "islands" | "preview" | "check"; generation: number }
    | { ask: "svg"; first: number; end: number }
    | { ask: "slow"; ms: number }; // for tests: each layer takes so much longer

/// Contours of a layer. Six numbers each in `rows`: role, part, parent, points, length, area.
export interface Layer {
    seq: number;
    index: number;
    ms: number;
    points: Float32Array; // x, y in mm about the middle of the mesh
    ends: Uint32Array; // where each contour's points end
    rows: Float64Array;
    gaps: Float32Array; // joined: four numbers each
}

export interface Below {
    seq: number;
    islands: number[]; // contours with nothing below; of a layer that has open contours they are not known
    unknown: string;
    points: Float32Array; // overhang
    ends: Uint32Array;
    area: number;
}

export interface Checked {
    generation: number;
    verdict: string;
    faults: { name: string; count: number }[];
    lines: Float32Array;
    points: Float32Array;
}

export type Answer =
    | { say: "ready" }
    | { say: "progress"; fraction: number }
    | { say: "opened"; generation: number; mesh: MeshInfo; ms: number }
    | { say: "planned"; generation: number; slabs: Float64Array<ArrayBuffer> }
    | { say: "areas"; generation: number; from: number; rows: Float64Array; hash: string; gaps: string; open: string }
    | ({ say: "layer" } & Layer)
    | ({ say: "below" } & Below)
    | { say: "islands"; generation: number; rows: Float64Array; upto: number; unknown: number }
    | { say: "preview"; generation: number; triangles: Float32Array }
    | ({ say: "checked" } & Checked)
    | { say: "svg"; bytes: Uint8Array }
    | { say: "failed"; ask: Question["ask"]; message: string }
    | { say: "dead"; message: string };

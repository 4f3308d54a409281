// All that the page knows, and the one place that asks for a frame when it changes.
import type { Below, Checked, Layer, MeshInfo, Plan } from "./protocol";

export interface Island {
    layer: number;
    contour: number;
    x: number;
    y: number;
    area: number;
}

export const state = {
    name: "",
    mesh: null as MeshInfo | null,
    plan: { height: 0.2, cusp: 0, stitch: -1, closing: 0, rule: 2 } as Plan,
    slabs: new Float64Array(), // bottom and top of each layer
    sums: new Float64Array(), // of each layer: area of closed contours, contours, holes, open ones
    swept: 0,
    hash: "",
    gaps: "", // that were joined
    open: "", // what is said of open layers
    index: 0, // of the wanted layer
    height: NaN, // mm; kept when layers change
    layer: null as Layer | null,
    below: null as Below | null,
    islands: [] as Island[],
    islands_upto: 0,
    islands_unknown: 0,
    triangles: null as Float32Array | null, // to look at, nine numbers each
    checked: null as Checked | null,
    checking: false,
    selected: -1, // contour
    hovered: -1,
    pointer: null as [number, number] | null, // mm
    outline: true,
    fill: true,
    colour: "role" as "role" | "part",
    show_islands: true,
    overhang: 0, // degrees from upright; 0: off
    view: "both" as "both" | "layer" | "3d",
    busy: "", // what is being waited for
    fraction: -1,
    error: "",
    notice: "",
    draw_ms: 0,
};

export const layer_count = () => state.slabs.length / 2;
export const plane_of = (index: number) => (state.slabs[2 * index]! + state.slabs[2 * index + 1]!) / 2;
export const centre = (): [number, number, number] => {
    const { min, max } = state.mesh!;
    return [(min[0] + max[0]) / 2, (min[1] + max[1]) / 2, (min[2] + max[2]) / 2];
};

/// The layer whose slab holds that height, or the nearest.
export function layer_at(mm: number): number {
    let low = 0, high = layer_count() - 1;
    while (low < high) {
        const middle = (low + high) >> 1;
        mm < state.slabs[2 * middle + 1]! ? (high = middle) : (low = middle + 1);
    }
    return low;
}

const drawers: (() => void)[] = [];
let asked = false;

export function on_frame(draw: () => void): void {
    drawers.push(draw);
}

/// Everything is drawn once in the next frame, however often something changes before it.
export function changed(): void {
    if (!asked) {
        asked = true;
        requestAnimationFrame(() => {
            asked = false;
            const begin = performance.now();
            drawers.forEach((draw) => draw());
            state.draw_ms = performance.now() - begin;
        });
    }
}

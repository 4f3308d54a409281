// The layer in Canvas 2D. Paths are made when a layer arrives, in mm with y up, and drawn again under another matrix while the view
// moves.
import { colour, fit_canvas, measure } from "./dom";
import { roles } from "./protocol";
import { state } from "./state";

const subpaths = 128; // a stroke of many is slow on some systems

interface Strokes {
    closed: boolean;
    role: number;
    part: number;
    paths: Path2D[];
    count: number;
}

export const view = { x: 0, y: 0, scale: 0 }; // mm about the middle of the mesh; CSS pixels a mm; 0: not fitted yet
let strokes = new Map<number, Strokes>();
let overhang: Path2D | null = null;
let overhang_of: unknown = null;
let built: unknown = null;
let blinked: unknown = null;

function trace(path: Path2D, points: Float32Array, first: number, end: number, closed: boolean): void {
    path.moveTo(points[2 * first]!, points[2 * first + 1]!);
    for (let i = first + 1; i < end; ++i) {
        path.lineTo(points[2 * i]!, points[2 * i + 1]!);
    }
    closed && path.closePath();
}

function build(): void {
    const layer = state.layer;
    strokes = new Map();
    for (let c = 0, first = 0; layer !== null && c < layer.ends.length; ++c) {
        const [role, part] = [layer.rows[6 * c]!, layer.rows[6 * c + 1]!];
        const closed = roles[role] !== "open";
        const key = role + 4 * part;
        let group = strokes.get(key);
        if (group === undefined) {
            strokes.set(key, (group = { closed, role, part, paths: [], count: 0 }));
        }
        if (group.count++ % subpaths === 0) {
            group.paths.push(new Path2D());
        }
        trace(group.paths.at(-1)!, layer.points, first, layer.ends[c]!, closed);
        first = layer.ends[c]!;
    }
}

export function contour_path(contour: number): Path2D {
    const layer = state.layer!;
    const path = new Path2D();
    trace(path, layer.points, contour === 0 ? 0 : layer.ends[contour - 1]!, layer.ends[contour]!, roles[layer.rows[6 * contour]!] !== "open");
    return path;
}

export function part_colour(part: number): string {
    return colour(`part${part % 8}`);
}

function line_colour(group: Strokes): string {
    return state.colour === "part" && group.role < 2 ? part_colour(group.part) : colour(roles[group.role]!);
}

/// All that is solid, without lines: the cap of the 3D view is this, too.
export function fill_layer(context: CanvasRenderingContext2D): void {
    if (built !== state.layer) {
        build();
        built = state.layer;
    }
    const solids = new Map<string, Path2D>();
    for (const group of strokes.values()) {
        if (group.closed) {
            const style = state.colour === "part" ? part_colour(group.part) : colour("solid");
            const path = solids.get(style) ?? new Path2D();
            group.paths.forEach((one) => path.addPath(one));
            solids.set(style, path);
        }
    }
    for (const [style, path] of solids) {
        context.fillStyle = style;
        context.globalAlpha = state.colour === "part" ? 0.5 : 1;
        context.fill(path, "nonzero");
    }
    context.globalAlpha = 1;
}

export function fit(canvas: HTMLCanvasElement, min = state.mesh!.min, max = state.mesh!.max, around = 0.9): void {
    const [width, height] = fit_canvas(canvas);
    const [w, h] = [Math.max(max[0]! - min[0]!, 1e-6), Math.max(max[1]! - min[1]!, 1e-6)];
    view.scale = around * Math.min(width / w, height / h);
    view.x = (min[0]! + max[0]!) / 2 - (state.mesh!.min[0] + state.mesh!.max[0]) / 2;
    view.y = (min[1]! + max[1]!) / 2 - (state.mesh!.min[1] + state.mesh!.max[1]) / 2;
}

export function to_mm(canvas: HTMLCanvasElement, x: number, y: number): [number, number] {
    return [view.x + (x - canvas.clientWidth / 2) / view.scale, view.y - (y - canvas.clientHeight / 2) / view.scale];
}

/// Zooms about a place on the canvas, which stays where it is.
export function zoom(canvas: HTMLCanvasElement, factor: number, x = canvas.clientWidth / 2, y = canvas.clientHeight / 2): void {
    const [mx, my] = to_mm(canvas, x, y);
    const largest = 1e6 / Math.hypot(state.mesh!.max[0] - state.mesh!.min[0], state.mesh!.max[1] - state.mesh!.min[1], 1e-3);
    view.scale = Math.min(Math.max(view.scale * factor, 1e-3), largest * 1e3);
    view.x = mx - (x - canvas.clientWidth / 2) / view.scale;
    view.y = my + (y - canvas.clientHeight / 2) / view.scale;
}

export function zoom_to(canvas: HTMLCanvasElement, contour: number): void {
    const layer = state.layer!;
    const [low, high] = [[Infinity, Infinity], [-Infinity, -Infinity]];
    for (let i = contour === 0 ? 0 : layer.ends[contour - 1]!; i < layer.ends[contour]!; ++i) {
        for (const axis of [0, 1]) {
            const at = layer.points[2 * i + axis]! + (state.mesh!.min[axis]! + state.mesh!.max[axis]!) / 2;
            low[axis] = Math.min(low[axis]!, at);
            high[axis] = Math.max(high[axis]!, at);
        }
    }
    fit(canvas, [low[0]!, low[1]!, 0], [high[0]!, high[1]!, 0], 0.6);
}

/// The contour with an edge within so many mm, or -1.
export function nearest([x, y]: [number, number], reach: number): number {
    const layer = state.layer;
    let best = reach * reach, found = -1;
    for (let c = 0, first = 0; layer !== null && c < layer.ends.length; first = layer.ends[c]!, ++c) {
        const end = layer.ends[c]!, { points } = layer;
        for (let i = first, before = roles[layer.rows[6 * c]!] === "open" ? first : end - 1; i < end; before = i++) {
            const ax = points[2 * before]!, ay = points[2 * before + 1]!;
            const dx = points[2 * i]! - ax, dy = points[2 * i + 1]! - ay;
            const along = Math.max(0, Math.min(1, ((x - ax) * dx + (y - ay) * dy) / (dx * dx + dy * dy || 1)));
            const distance = (x - ax - along * dx) ** 2 + (y - ay - along * dy) ** 2;
            if (distance < best) {
                [best, found] = [distance, c];
            }
        }
    }
    return found;
}

function draw_lines(context: CanvasRenderingContext2D, pixel: number): void {
    for (const group of strokes.values()) {
        const role = roles[group.role]!;
        context.strokeStyle = line_colour(group);
        context.lineWidth = (role === "outer" ? 1.6 : role === "open" ? 2 : 1.1) * pixel;
        context.setLineDash(role === "open" ? [6 * pixel, 4 * pixel] : []);
        group.paths.forEach((path) => context.stroke(path));
    }
    context.setLineDash([]);
}

function dot(context: CanvasRenderingContext2D, x: number, y: number, radius: number): void {
    context.beginPath();
    context.arc(x, y, radius, 0, 2 * Math.PI);
    context.fill();
}

/// Ends of open contours, and joined gaps as double lines.
function draw_gaps(context: CanvasRenderingContext2D, pixel: number): void {
    const { points, ends, rows, gaps } = state.layer!;
    context.fillStyle = colour("open");
    for (let c = 0; c < ends.length; ++c) {
        if (roles[rows[6 * c]!] === "open") {
            const first = c === 0 ? 0 : ends[c - 1]!, last = ends[c]! - 1;
            dot(context, points[2 * first]!, points[2 * first + 1]!, 3.5 * pixel);
            dot(context, points[2 * last]!, points[2 * last + 1]!, 3.5 * pixel);
        }
    }
    for (const [style, width] of [[colour("gap"), 5], [colour("ground"), 2]] as const) {
        context.strokeStyle = style;
        context.lineWidth = width * pixel;
        context.beginPath();
        for (let i = 0; i < gaps.length; i += 4) {
            context.moveTo(gaps[i]!, gaps[i + 1]!);
            context.lineTo(gaps[i + 2]!, gaps[i + 3]!);
        }
        context.stroke();
    }
}

function draw_below(context: CanvasRenderingContext2D, pixel: number): void {
    const below = state.below;
    if (below === null || below.seq !== state.layer!.seq) {
        return;
    }
    if (overhang_of !== below) {
        overhang_of = below;
        overhang = new Path2D();
        below.ends.forEach((end, c) => trace(overhang!, below.points, c === 0 ? 0 : below.ends[c - 1]!, end, true));
    }
    context.fillStyle = colour("overhang");
    context.fill(overhang!, "nonzero");
    if (state.show_islands) {
        const fresh = blinked !== below && below.islands.length > 0 && !matchMedia("(prefers-reduced-motion: reduce)").matches;
        blinked = below;
        context.strokeStyle = colour("island");
        context.lineWidth = (fresh ? 8 : 4) * pixel;
        below.islands.forEach((contour) => context.stroke(contour_path(contour)));
    }
}

function draw_scale(context: CanvasRenderingContext2D, height: number): void {
    const raw = 90 / view.scale, power = 10 ** Math.floor(Math.log10(raw));
    const length = power * (raw / power >= 5 ? 5 : raw / power >= 2 ? 2 : 1);
    context.strokeStyle = context.fillStyle = colour("ink");
    context.lineWidth = 1.5;
    context.beginPath();
    context.moveTo(14, height - 18);
    context.lineTo(14, height - 12);
    context.lineTo(14 + length * view.scale, height - 12);
    context.lineTo(14 + length * view.scale, height - 18);
    context.stroke();
    context.font = "12px system-ui, sans-serif";
    context.fillText(measure(length, " mm"), 18, height - 18);
}

export function draw_layer(canvas: HTMLCanvasElement): void {
    const [width, height, ratio] = fit_canvas(canvas);
    const context = canvas.getContext("2d")!;
    context.setTransform(1, 0, 0, 1, 0, 0);
    context.clearRect(0, 0, canvas.width, canvas.height);
    if (state.layer === null || view.scale === 0) {
        return;
    }
    const scale = view.scale * ratio, pixel = 1 / view.scale;
    context.setTransform(scale, 0, 0, -scale, (width * ratio) / 2 - view.x * scale, (height * ratio) / 2 + view.y * scale);
    context.lineJoin = context.lineCap = "round";
    if (built !== state.layer) {
        build();
        built = state.layer;
    }
    state.fill && fill_layer(context);
    draw_below(context, pixel);
    state.outline && draw_lines(context, pixel);
    draw_gaps(context, pixel);
    for (const [contour, width] of [[state.hovered, 2.5], [state.selected, 4]] as const) {
        if (contour >= 0 && contour < state.layer.ends.length) {
            context.strokeStyle = colour("chosen");
            context.lineWidth = width * pixel;
            context.stroke(contour_path(contour));
        }
    }
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    draw_scale(context, height);
}

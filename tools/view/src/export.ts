// Files that the page writes, and the command that does the same at a terminal.
import { save } from "./dom";
import { colour } from "./dom";
import { roles, rules } from "./protocol";
import { layer_count, plane_of, state } from "./state";

export const stem = () => state.name.replace(/(\.gz)?$/i, "").replace(/\.[^.]*$/, "") || "mesh";

/// One cell: a name that a spreadsheet would take for a formula begins with a quote mark.
export function cell(value: string | number): string {
    const text = typeof value === "string" && /^[=+\-@\t\r]/.test(value) ? `'${value}` : String(value);
    return /[",\n\r]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
}

const csv = (rows: (string | number)[][]) => rows.map((row) => row.map(cell).join(",") + "\n").join("");

export function layers_csv(): string {
    const rows: (string | number)[][] = [["layer", "bottom_mm", "plane_mm", "top_mm", "area_mm2", "contours", "holes", "open"]];
    for (let i = 0; i < state.swept; ++i) {
        const [area, contours, holes, open] = state.sums.subarray(4 * i, 4 * i + 4);
        rows.push([i, state.slabs[2 * i]!, plane_of(i), state.slabs[2 * i + 1]!, open! > 0 ? "" : area!, contours!, holes!, open!]);
    }
    return csv(rows);
}

export function contours_csv(): string {
    const rows: (string | number)[][] = [["contour", "role", "part", "parent", "points", "length_mm", "area_mm2"]];
    const layer = state.layer!, parts = state.mesh!.parts;
    for (let c = 0; c < layer.ends.length; ++c) {
        const [role, part, parent, points, length, area] = layer.rows.subarray(6 * c, 6 * c + 6);
        rows.push([c, roles[role!]!, parts[part!] ?? part!, parent! < 0 ? "" : parent!, points!, length!, area!]);
    }
    return csv(rows);
}

export function save_csv(of: "layers" | "contours"): void {
    const text = of === "layers" ? layers_csv() : contours_csv();
    save(`${stem()}${of === "layers" ? "" : `_layer${state.index}`}.csv`, text, "text/csv");
}

export function save_png(canvas: HTMLCanvasElement): void {
    const whole = document.createElement("canvas");
    [whole.width, whole.height] = [canvas.width, canvas.height];
    const context = whole.getContext("2d")!;
    context.fillStyle = colour("ground");
    context.fillRect(0, 0, whole.width, whole.height);
    context.drawImage(canvas, 0, 0);
    whole.toBlob((blob) => blob !== null && save(`${stem()}_layer${state.index}.png`, blob, "image/png"));
}

/// Prints the hash that the page shows, of the same layers.
export function command(): string {
    const { height, cusp, stitch, closing, rule } = state.plan;
    const heights = cusp > 0 ? `--cusp ${cusp} --heights ${height / 4}:${height} --height-step ${height / 40}` : `--layer-height ${height}`;
    const words = ["lamella slice", `'${state.name.replaceAll("'", "'\\''")}'`, heights];
    stitch !== -1 && words.push(`--stitch ${stitch}`);
    closing > 0 && words.push(`--closing ${closing}`);
    rule !== 2 && words.push(`--fill-rule ${rules[rule]}`);
    return layer_count() > 0 ? [...words, "--hash"].join(" ") : "";
}

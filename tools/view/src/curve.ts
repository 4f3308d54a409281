// The area over the height, upright beside the layer: the slider.
import { colour, fit_canvas, measure } from "./dom";
import { layer_at, layer_count, plane_of, state } from "./state";

const margin = 8; // above and below the curve

const span = (): [number, number] => [state.slabs[0]!, state.slabs[state.slabs.length - 1]!];

export function height_at(canvas: HTMLCanvasElement, y: number): number {
    const [low, high] = span();
    const share = 1 - (y - margin) / Math.max(canvas.clientHeight - 2 * margin, 1);
    return low + Math.max(0, Math.min(1, share)) * (high - low);
}

/// The least and the largest area of the layers in each row of pixels, since there may be more layers than rows.
function draw_areas(context: CanvasRenderingContext2D, width: number, rows: number, most: number): void {
    const [low, high] = span();
    for (let row = 0; row < rows; ++row) {
        const first = layer_at(low + (row / rows) * (high - low));
        const last = Math.max(first, layer_at(low + ((row + 1) / rows) * (high - low)) - 1);
        let least = Infinity, largest = 0, open = false;
        for (let i = first; i <= Math.min(last, state.swept - 1); ++i) {
            least = Math.min(least, state.sums[4 * i]!);
            largest = Math.max(largest, state.sums[4 * i]!);
            open ||= state.sums[4 * i + 3]! > 0;
        }
        if (least <= largest) {
            const y = margin + rows - row - 1;
            context.fillStyle = colour(open ? "open" : "area");
            context.fillRect(0, y, (largest / most) * width, 1);
            context.fillStyle = colour("area-least");
            context.fillRect(0, y, (least / most) * width, 1);
        }
    }
}

function draw_islands(context: CanvasRenderingContext2D, width: number, rows: number): void {
    const [low, high] = span();
    context.fillStyle = colour("island");
    for (const island of state.show_islands ? state.islands : []) {
        context.fillRect(width - 6, margin + rows * (1 - (plane_of(island.layer) - low) / (high - low)) - 1, 6, 2);
    }
}

export function draw_curve(canvas: HTMLCanvasElement): void {
    const [width, height, ratio] = fit_canvas(canvas);
    const context = canvas.getContext("2d")!;
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.clearRect(0, 0, width, height);
    if (layer_count() === 0) {
        return;
    }
    const rows = Math.floor(height - 2 * margin);
    let most = 1e-12;
    for (let i = 0; i < state.swept; ++i) {
        most = Math.max(most, state.sums[4 * i]!);
    }
    draw_areas(context, width - 10, rows, most);
    draw_islands(context, width, rows);
    const [low, high] = span();
    context.fillStyle = colour("faint");
    context.font = "11px system-ui, sans-serif";
    context.textAlign = "right";
    context.fillText(`${Number(high.toFixed(2))} mm`, width - 12, margin + 9);
    context.fillText(`${Number(low.toFixed(2))} mm`, width - 12, height - margin - 2);
    const y = margin + rows * (1 - (plane_of(state.index) - low) / (high - low));
    context.fillStyle = colour("plane");
    context.fillRect(0, y - 1, width, 2);
    context.beginPath();
    context.moveTo(width, y - 6);
    context.lineTo(width - 9, y);
    context.lineTo(width, y + 6);
    context.fill();
    const area = state.index < state.swept ? state.sums[4 * state.index]! : NaN;
    canvas.ariaValueMax = String(layer_count() - 1);
    canvas.ariaValueNow = String(state.index);
    canvas.ariaValueText = `${measure(plane_of(state.index))} mm, layer ${state.index} of ${layer_count()}, ${measure(area)} mm2`;
}

// The view in the address: #z=12.4&h=0.1&... What is not a finite number within its range is left out.
import { view } from "./layer";
import type { Plan } from "./protocol";
import { layer_count, plane_of, state } from "./state";

const ranges: Record<string, [number, number]> = {
    z: [-1e9, 1e9], x: [-1e9, 1e9], y: [-1e9, 1e9], s: [1e-6, 1e9],
    h: [1e-6, 1e6], cusp: [0, 1e6], stitch: [-1, 1e6], closing: [0, 1e6], rule: [0, 4],
};

export function parse_link(hash: string): Record<string, number> {
    const found: Record<string, number> = {};
    for (const [name, text] of new URLSearchParams(hash.replace(/^#/, ""))) {
        const range = Object.hasOwn(ranges, name) ? ranges[name] : undefined, value = Number(text);
        if (range !== undefined && text.trim() !== "" && Number.isFinite(value)) {
            found[name] = Math.min(Math.max(value, range[0]), range[1]);
        }
    }
    return found;
}

export function plan_of_link({ h, cusp, stitch, closing, rule }: Record<string, number>, plan: Plan): Plan {
    return {
        height: h ?? plan.height, cusp: cusp ?? plan.cusp, stitch: stitch ?? plan.stitch,
        closing: closing ?? plan.closing, rule: Math.round(rule ?? plan.rule),
    };
}

let timer = 0;
/// Soon: browsers refuse an address that changes with every move.
export function remember(): void {
    clearTimeout(timer);
    timer = setTimeout(() => {
        if (layer_count() === 0) {
            return;
        }
        const { height, cusp, stitch, closing, rule } = state.plan;
        const numbers = { z: plane_of(state.index), h: height, cusp, stitch, closing, rule, x: view.x, y: view.y, s: view.scale };
        const words = Object.entries(numbers).map(([name, value]) => `${name}=${Number(value.toPrecision(9))}`);
        history.replaceState(null, "", `#${words.join("&")}`);
    }, 400);
}

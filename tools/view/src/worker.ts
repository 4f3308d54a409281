// The worker: answers questions as they come, and between them sweeps all layers for areas, hash and islands, in pieces of a few
// milliseconds, so that a question waits no longer than a piece.
import { Engine, Refused } from "./engine";
import type { Answer, Question } from "./protocol";

declare function postMessage(message: Answer, transfer?: Transferable[]): void;

const piece_ms = 6;
const rest_ms = 60; // the sweep stands back while layers are asked for

let engine: Engine;
let early: Exclude<Question, { ask: "boot" }>[] | null = []; // that came before the engine stood
let generation = 0;
let slow_ms = 0;
let layers = 0;
let swept = 0;
let scanned = Infinity; // islands are known below this layer; Infinity: nobody asked
let unknown = 0;
let piece = 1; // layers
let ticking = false;
let last_asked = 0;
let last_told = 0;

const turn = new MessageChannel();
turn.port1.onmessage = () => guard("plan", work);

function tell_progress(fraction: number): void {
    const now = performance.now();
    if (now - last_told > 100) {
        last_told = now;
        postMessage({ say: "progress", fraction });
    }
}

/// An error of the engine is a line; anything else, such as a trap, costs the worker its life.
function guard(ask: Question["ask"], action: () => void): void {
    try {
        action();
    } catch (error) {
        const message = error instanceof Error ? error.message : String(error);
        postMessage(error instanceof Refused ? { say: "failed", ask, message } : { say: "dead", message });
    }
}

function wake(): void {
    if (!ticking && (swept < layers || scanned < layers)) {
        ticking = true;
        turn.port2.postMessage(0);
    }
}

function work(): void {
    ticking = false;
    if (performance.now() - last_asked < rest_ms) {
        ticking = true;
        setTimeout(() => turn.port2.postMessage(0), rest_ms);
        return;
    }
    const begin = performance.now();
    const count = piece;
    swept < layers ? sweep(count) : scanned < layers && scan(count);
    const ms = performance.now() - begin;
    piece = Math.max(1, Math.min(4 * count, Math.round((count * piece_ms) / Math.max(ms, 0.1)), 2000));
    wake();
}

function sweep(count: number): void {
    engine.call("sweep", ["number"], count);
    const rows = engine.rows(), from = swept;
    swept += rows.length / 4;
    const [hash = "", gaps = "", open = ""] = engine.text().split("\n");
    postMessage({ say: "areas", generation, from, rows, hash, gaps, open }, [rows.buffer]);
}

function scan(count: number): void {
    const end = Math.min(scanned + count, layers);
    let rows = new Float64Array();
    try {
        engine.call("islands", ["number", "number"], scanned, end);
        rows = engine.rows();
    } catch (error) {
        if (!(error instanceof Refused)) {
            throw error;
        }
        if (end > scanned + 1) {
            scan(1); // find the layer that has open contours
            return;
        }
        unknown += 1;
    }
    scanned = end;
    postMessage({ say: "islands", generation, rows, upto: scanned, unknown }, [rows.buffer]);
}

function show(asked: Extract<Question, { ask: "layer" }>): void {
    last_asked = performance.now();
    while (performance.now() - last_asked < slow_ms) {
        // as a slower machine would
    }
    engine.call("layer", ["number", "number"], asked.index, asked.pixel);
    const points = engine.floats(0), gaps = engine.floats(1), rows = engine.rows(), ends = engine.ends();
    const ms = performance.now() - last_asked;
    postMessage({ say: "layer", seq: asked.seq, index: asked.index, ms, points, ends, rows, gaps }, [points.buffer, ends.buffer, rows.buffer, gaps.buffer]);
}

function look_below({ seq, index, degrees, pixel }: Extract<Question, { ask: "below" }>): void {
    let islands: number[] = [], unknown = "";
    try {
        engine.call("islands", ["number", "number"], index, index + 1);
        const rows = engine.rows();
        for (let i = 0; i < rows.length; i += 5) {
            islands.push(rows[i + 1]!);
        }
    } catch (error) {
        if (!(error instanceof Refused)) {
            throw error;
        }
        unknown = error.message;
    }
    let area = 0, points = new Float32Array(), ends = new Uint32Array();
    if (degrees > 0 && unknown === "") {
        engine.call("overhang", ["number", "number", "number"], index, degrees, pixel);
        [points, ends, area] = [engine.floats(0), engine.ends(), engine.rows()[0]!];
    }
    postMessage({ say: "below", seq, islands, unknown, points, ends, area });
}

function open(asked: Extract<Question, { ask: "open" }>): void {
    const begin = performance.now();
    engine.open(asked.file, asked.name, asked.unit);
    generation = asked.generation;
    layers = swept = 0;
    scanned = Infinity;
    postMessage({ say: "opened", generation, mesh: JSON.parse(engine.text()), ms: performance.now() - begin });
}

function plan({ generation: asked, plan: { height, cusp, stitch, closing, rule } }: Extract<Question, { ask: "plan" }>): void {
    engine.call("plan", ["number", "number", "number", "number", "number"], height, cusp, stitch, closing, rule);
    const slabs = engine.rows();
    generation = asked;
    layers = slabs.length / 2;
    swept = unknown = 0;
    scanned = Infinity;
    piece = 1;
    postMessage({ say: "planned", generation, slabs }, [slabs.buffer]);
    layers === 0 && sweep(0); // its hash
}

function check(generation: number): void {
    engine.call("check", ["number"], 5000);
    const lines = engine.floats(0), points = engine.floats(1);
    postMessage({ say: "checked", generation, ...JSON.parse(engine.text()), lines, points });
}

function answer(asked: Exclude<Question, { ask: "boot" }>): void {
    switch (asked.ask) {
        case "open": return open(asked);
        case "plan": return plan(asked);
        case "layer": return show(asked);
        case "below": return look_below(asked);
        case "islands": scanned = Math.min(scanned, 0); return;
        case "check": return check(asked.generation);
        case "svg": return postMessage({ say: "svg", bytes: engine.svg(asked.first, asked.end) });
        case "slow": slow_ms = asked.ms; return;
        case "preview": {
            engine.call("preview", []);
            const triangles = engine.floats(0);
            return postMessage({ say: "preview", generation: asked.generation, triangles }, [triangles.buffer]);
        }
    }
}

function take(asked: Exclude<Question, { ask: "boot" }>): void {
    guard(asked.ask, () => answer(asked));
    wake();
}

onmessage = ({ data: asked }: MessageEvent<Question>) => {
    if (asked.ask !== "boot") {
        early === null ? take(asked) : early.push(asked);
        return;
    }
    void Engine.start(asked.module, tell_progress).then((started) => {
        engine = started;
        postMessage({ say: "ready" });
        early!.forEach(take);
        early = null;
    });
};

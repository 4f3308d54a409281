// The page's side of the worker: one wanted layer, at most one on the way, no queue; and a worker that died comes back with the mesh
// that was open.
import { element } from "./dom";
import type { Answer, Plan, Question } from "./protocol";
import { changed, layer_count, state } from "./state";

export interface Source {
    file: Blob;
    name: string;
    unit: number; // mm, of files that state none
}

type Handler = (answer: Answer) => void;

async function unpack(id: string): Promise<ArrayBuffer> {
    const packed = new Blob([bytes_of(element(id).textContent!)]);
    return new Response(packed.stream().pipeThrough(new DecompressionStream("gzip"))).arrayBuffer();
}

export function bytes_of(base64: string): Uint8Array<ArrayBuffer> {
    const text = atob(base64.trim());
    const bytes = new Uint8Array(text.length);
    for (let i = 0; i < text.length; ++i) {
        bytes[i] = text.charCodeAt(i);
    }
    return bytes;
}

export class Client {
    private generation = 0; // of what is shown
    private mesh_generation = 0;
    private latest = 0; // of what was asked for
    pixel = 0; // mm that half a pixel's points may lie apart
    waiting = 0; // layers on the way
    private worker!: Worker;
    private checker: Worker | null = null;
    private module!: WebAssembly.Module;
    private source: Source | null = null; // that is open
    private opening: Source | null = null;
    private reopening = false;
    private seq = 0;
    private drawn_index = -1;
    private drawn_pixel = 0;

    constructor(private readonly handle: Handler) {}

    async start(): Promise<void> {
        this.module = await WebAssembly.compile(await unpack("core"));
        this.spawn();
    }

    ask(question: Question): void {
        this.worker.postMessage(question);
    }

    open(source: Source): void {
        this.opening = source;
        this.reopening = false;
        state.busy = `reading ${source.name}`;
        state.fraction = 0;
        state.error = state.notice = "";
        this.ask({ ask: "open", generation: ++this.latest, ...source });
        changed();
    }

    /// The same file, where it states no unit of its own, in another.
    reopen(unit: number): void {
        this.source !== null && this.open({ ...this.source, unit });
    }

    plan(plan: Plan): void {
        this.ask({ ask: "plan", generation: ++this.latest, plan });
    }

    /// Called once a frame: the last wish is what is asked for.
    pursue(): void {
        const coarser = this.pixel < this.drawn_pixel * 0.6;
        if (this.waiting === 0 && layer_count() > 0 && (state.index !== this.drawn_index || coarser)) {
            this.drawn_index = state.index;
            this.drawn_pixel = this.pixel;
            this.waiting = 1;
            this.ask({ ask: "layer", seq: ++this.seq, index: state.index, pixel: this.pixel });
        }
    }

    forget_layer(): void {
        this.drawn_index = -1;
        this.waiting = 0;
        this.seq += 1;
    }

    more(ask: "islands" | "preview"): void {
        this.ask({ ask, generation: ask === "preview" ? this.mesh_generation : this.generation });
    }

    below(): void {
        const degrees = state.overhang;
        this.ask({ ask: "below", seq: this.seq, index: state.index, degrees, pixel: this.pixel });
    }

    /// In a worker of its own, as it may take long: planes follow the pointer meanwhile.
    check(): void {
        if (this.source === null || state.checking) {
            return;
        }
        state.checking = true;
        const { mesh_generation: generation, source } = this;
        this.checker = this.make_worker((answer) => {
            if (answer.say === "ready") {
                this.checker!.postMessage({ ask: "open", generation, ...source! } satisfies Question);
            } else if (answer.say === "opened") {
                this.checker!.postMessage({ ask: "check", generation } satisfies Question);
            } else if (answer.say !== "progress") {
                this.end_check();
                this.handle(answer.say === "dead" ? { say: "failed", ask: "check", message: answer.message } : answer);
            }
        });
        changed();
    }

    /// Ends what is under way: a call of the engine cannot be stopped but with its worker.
    cancel(): void {
        if (state.busy !== "" || state.checking) {
            this.end_check();
            if (state.busy !== "") {
                this.opening = null;
                this.restart("Stopped.");
            }
            changed();
        }
    }

    private end_check(): void {
        this.checker?.terminate();
        this.checker = null;
        state.checking = false;
    }

    private spawn(): void {
        this.worker = this.make_worker((answer) => this.take(answer));
    }

    private make_worker(take: Handler): Worker {
        const address = URL.createObjectURL(new Blob([element("worker").textContent!], { type: "text/javascript" }));
        const worker = new Worker(address);
        URL.revokeObjectURL(address);
        worker.onmessage = (event) => take(event.data);
        worker.onerror = (event) => take({ say: "dead", message: event.message });
        worker.postMessage({ ask: "boot", module: this.module } satisfies Question);
        return worker;
    }

    private restart(notice: string): void {
        this.worker.terminate();
        state.busy = "";
        state.fraction = -1;
        this.forget_layer();
        this.spawn();
        state.notice = notice;
        this.handle({ say: "dead", message: notice });
        if (this.source !== null && !this.reopening) {
            this.reopening = true;
            this.ask({ ask: "open", generation: ++this.latest, ...this.source });
        }
    }

    private take(answer: Answer): void {
        if (answer.say === "dead") {
            const culprit = this.opening;
            this.opening = null;
            this.restart("The engine stopped and was started again.");
            state.error = culprit === null ? "" : `${culprit.name}: the engine stopped while it read this file: ${answer.message}`;
            changed();
            return;
        }
        const fresh = answer.say === "opened" || answer.say === "planned", of_mesh = answer.say === "preview" || answer.say === "checked";
        if ("generation" in answer && answer.generation !== (fresh ? this.latest : of_mesh ? this.mesh_generation : this.generation)) {
            return;
        }
        this.generation = fresh ? this.latest : this.generation;
        this.mesh_generation = answer.say === "opened" ? this.latest : this.mesh_generation;
        if (answer.say === "opened") {
            const again = this.reopening;
            this.reopening = false;
            this.source = this.opening ?? this.source;
            this.opening = null;
            state.busy = "";
            state.fraction = -1;
            this.forget_layer();
            if (again) {
                this.plan(state.plan);
                return;
            }
            this.end_check();
            state.name = this.source!.name;
        }
        if (answer.say === "failed" && answer.ask === "open") {
            const name = this.opening?.name ?? "";
            answer.message = answer.message.includes(name) ? answer.message : `${name}: ${answer.message}`;
            this.opening = null;
            state.busy = "";
            state.fraction = -1;
        }
        if (answer.say === "layer") {
            if (answer.seq !== this.seq) {
                return;
            }
            this.waiting = 0;
        }
        if (answer.say === "failed" && answer.ask === "layer") {
            this.waiting = 0;
        }
        if (answer.say === "below" && answer.seq !== this.seq) {
            return;
        }
        this.handle(answer);
        changed();
    }
}

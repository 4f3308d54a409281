// Several meshes, or ranges of layers of one, at once in workers: each has an engine of its own, of one compiled module.
import { checked, compile, fail, node, SliceError, SliceResult, type Mesh, type SliceOptions, type Source } from "./slicer.js";
import type { Answer } from "./worker.js";
export { Contour, SliceError, Slicer, SliceResult } from "./slicer.js";
export type { ErrorCode, Layer, Mesh, SliceInfo, SliceOptions, Source } from "./slicer.js";

interface Job {
    mesh: Mesh;
    options: SliceOptions;
    resolve(result: SliceResult): void;
    reject(error: SliceError): void;
}
/// A worker of a page or of node, and what it does.
interface Hand {
    worker: any;
    job: Job | undefined;
}

export class SlicePool {
    readonly #hands = new Set<Hand>();
    readonly #queue: Job[] = [];
    #closed = false;

    private constructor(
        private readonly module: WebAssembly.Module,
        readonly workers: number,
        private readonly NodeWorker: any,
    ) {}

    /** At most so many workers, by default one a processor. They start when there is work. */
    static async create({ workers, source }: { workers?: number; source?: Source } = {}): Promise<SlicePool> {
        const kind = globalThis.Worker ? undefined : (await node("worker_threads")).Worker;
        const processors = kind ? (await node("os")).availableParallelism() : navigator.hardwareConcurrency;
        const most = workers ?? processors ?? 2;
        return most >= 1 ? new SlicePool(await compile(source), most, kind) : fail("invalid_argument", `workers are ${most}, not at least 1`);
    }

    /** Results in the order of the meshes; the first error rejects. */
    slice(meshes: Iterable<Mesh>, options?: SliceOptions): Promise<SliceResult[]> {
        return Promise.all(Array.from(meshes, (mesh) => this.sliceOne(mesh, options)));
    }

    /** The mesh is copied. */
    sliceOne(mesh: Mesh, options: SliceOptions = {}): Promise<SliceResult> {
        return new Promise((resolve, reject) => {
            const { positions, indices, ...rest } = this.#closed ? fail("cancelled", "the pool is closed") : checked(mesh);
            const copied = { positions: positions.slice(), indices: indices?.slice(), ...rest };
            this.#queue.push({ mesh: copied, options: structuredClone(options), resolve, reject });
            this.#next();
        });
    }

    /** Ends the workers; what is not done is rejected. */
    async close(): Promise<void> {
        this.#closed = true;
        const hands = [...this.#hands];
        const jobs = [...hands.map(({ job }) => job), ...this.#queue.splice(0)];
        this.#hands.clear();
        jobs.forEach((job) => job?.reject(new SliceError("cancelled", "the pool was closed")));
        await Promise.all(hands.map(({ worker }) => worker.terminate()));
    }

    #next(): void {
        const job = this.#queue[0];
        const hand = job && ([...this.#hands].find((one) => !one.job) ?? (this.#hands.size < this.workers ? this.#hire() : undefined));
        if (hand) {
            hand.job = this.#queue.shift()!;
            const { mesh, options } = hand.job;
            hand.worker.ref?.(); // an idle worker keeps no program of node's from ending
            hand.worker.postMessage({ module: this.module, mesh, options }, [mesh.positions, mesh.indices].flatMap((array) => array?.buffer ?? []));
        }
    }

    #hire(): Hand {
        const address = new URL("./worker.js", import.meta.url);
        const hand: Hand = { worker: undefined, job: undefined };
        const said = (answer: Answer) => this.#take(hand, answer);
        const died = (error?: { message?: string }) => said({ code: "lost", message: `a worker ended: ${error?.message ?? "it exited"}` });
        hand.worker = this.NodeWorker
            ? new this.NodeWorker(address).on("message", said).on("error", died).on("exit", () => died())
            : Object.assign(new Worker(new URL("./worker.js", import.meta.url), { type: "module" }), {
                  onmessage: ({ data }: MessageEvent) => said(data),
                  onerror: died,
              });
        this.#hands.add(hand);
        return hand;
    }

    #take(hand: Hand, answer: Answer): void {
        if ("flat" in answer) {
            hand.job?.resolve(new SliceResult(answer.flat));
        } else {
            hand.job?.reject(new SliceError(answer.code, answer.message));
            answer.code === "lost" && this.#hands.delete(hand) && hand.worker.terminate();
        }
        hand.job = undefined;
        hand.worker.unref?.();
        this.#next();
    }
}

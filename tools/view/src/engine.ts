// The engine's flat calls, as view_core.cpp has them.
/// <reference path="./core.d.ts" />
import createCore from "lamella-core";
import { gzip } from "./protocol";

export class Refused extends Error {}

const folder = "/mesh";

export class Engine {
    private constructor(private readonly core: Core) {}

    static async start(module: WebAssembly.Module, progress: (fraction: number) => void): Promise<Engine> {
        const core = await createCore({
            progress,
            instantiateWasm(imports: WebAssembly.Imports, done: (instance: WebAssembly.Instance) => void) {
                void WebAssembly.instantiate(module, imports).then(done);
                return {};
            },
        });
        core.FS.mkdir(folder);
        return new Engine(core);
    }

    /// Throws Refused with the engine's line. A RuntimeError means that the module is lost.
    call(name: string, types: CoreType[], ...values: (number | string)[]): void {
        if (this.core.ccall(`view_${name}`, "number", types, values) === 0) {
            throw new Refused(this.text());
        }
    }

    /// The file is read where it is: a blob's bytes are never copied as a whole.
    open(file: Blob, name: string, unit: number): void {
        const FS = this.core.FS;
        const ending = file.type === gzip && !/\.gz$/i.test(name) ? ".gz" : ""; // as the reader wants it
        const plain = (name.replace(/[/\0]/g, "_").slice(-120) || "mesh") + ending;
        FS.mount(this.core.WORKERFS, { blobs: [{ name: plain, data: file }] }, folder);
        try {
            this.call("open", ["string", "number", "string"], `${folder}/${plain}`, unit, "");
        } catch (error) {
            throw error instanceof Refused ? new Refused(error.message.replaceAll(`${folder}/`, "")) : error;
        } finally {
            FS.unmount(folder);
        }
    }

    svg(first: number, end: number): Uint8Array {
        this.call("svg", ["number", "number", "string"], first, end, "/layers.svg");
        const bytes = this.core.FS.readFile("/layers.svg");
        this.core.FS.unlink("/layers.svg");
        return bytes;
    }

    floats = (which: 0 | 1) => new Float32Array(this.copy(which, 4));
    rows = () => new Float64Array(this.copy(2, 8));
    ends = () => new Uint32Array(this.copy(3, 4));
    text = () => new TextDecoder().decode(this.copy(-1, 1));

    private copy(which: number, width: number): ArrayBuffer {
        const at = this.core.ccall("view_data", "number", ["number"], [which]) >>> 0; // addresses from 2 GB on come out negative
        const size = this.core.ccall("view_size", "number", ["number"], [which]) >>> 0;
        return this.core.HEAPU8.slice(at, at + size * width).buffer;
    }
}

// A worker of a pool: slices what it is sent.
import { node, SliceError, Slicer, type ErrorCode, type Flat } from "./slicer.js";
export type Answer = { flat: Flat } | { code: ErrorCode; message: string };
const port: any = "postMessage" in globalThis ? globalThis : (await node("worker_threads")).parentPort;
let slicer: Slicer | undefined;
port.onmessage = async ({ data: { module, mesh, options } }: MessageEvent) => {
    try {
        const { flat } = (slicer ??= await Slicer.load(module)).slice(mesh, options);
        port.postMessage({ flat }, [flat.layers, flat.contours, flat.points]);
    } catch (error) {
        port.postMessage({ code: error instanceof SliceError ? error.code : "lost", message: String((error as Error).message) });
    }
};

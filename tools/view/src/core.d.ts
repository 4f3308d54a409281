// What emscripten makes of tools/view/core.
type CoreType = "number" | "string";
interface Core {
    ccall(name: string, returns: "number", types: CoreType[], values: (number | string)[]): number;
    readonly HEAPU8: Uint8Array<ArrayBuffer>;
    readonly WORKERFS: object;
    readonly FS: {
        mkdir(path: string): void;
        mount(type: object, options: object, path: string): void;
        unmount(path: string): void;
        readFile(path: string): Uint8Array;
        unlink(path: string): void;
    };
}
declare module "lamella-core" {
    export default function createCore(options: object): Promise<Core>;
}

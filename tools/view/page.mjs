// node page.mjs BUILD-FOLDER: makes BUILD-FOLDER/view.html, one page, of the sources here and the core in that folder.
import { createHash } from "node:crypto";
import { readFileSync, writeFileSync } from "node:fs";
import { gzipSync } from "node:zlib";
import esbuild from "esbuild";

const folder = process.argv[2], most_bytes = 1.5e6;
const here = (name) => readFileSync(new URL(name, import.meta.url), "utf8");

function bundle(entry) {
    const built = esbuild.buildSync({
        entryPoints: [new URL(`src/${entry}.ts`, import.meta.url).pathname],
        alias: { "lamella-core": `${folder}/core.js` },
        external: ["fs", "path", "crypto", "perf_hooks"], // named in branches for node, which a page never takes
        bundle: true, minify: true, format: "iife", target: "es2022", charset: "utf8", legalComments: "inline", write: false, metafile: true,
    });
    const foreign = Object.keys(built.metafile.inputs).filter((path) => path.includes("node_modules"));
    if (foreign.length > 0) {
        throw new Error(`a library without its licence in the page: ${foreign}`);
    }
    // Within an HTML script these begin or end something.
    return built.outputFiles[0].text.replaceAll("</script", "<\\/script").replaceAll("<!--", "<\\!--");
}

const parts = {
    STYLE: esbuild.transformSync(here("page.css"), { loader: "css", minify: true }).code.trim(),
    MAIN: bundle("main"), WORKER: bundle("worker"), CORE: gzipSync(readFileSync(`${folder}/core.wasm`), { level: 9 }).toString("base64"),
    LICENCES: readFileSync(`${folder}/licences.txt`, "utf8").replaceAll("&", "&amp;").replaceAll("<", "&lt;"),
};
const hash = (text) => `'sha256-${createHash("sha256").update(text).digest("base64")}'`;
parts.POLICY = `default-src 'none'; script-src ${hash(parts.MAIN)} 'wasm-unsafe-eval'; worker-src blob:; style-src ${hash(parts.STYLE)}; ` +
    "img-src data: blob:; connect-src 'none'; base-uri 'none'; form-action 'none'";
const page = here("page.html").replace(/%([A-Z]+)%/g, (_, name) => parts[name]);
if (Buffer.byteLength(page) > most_bytes) {
    throw new Error(`the page has ${Buffer.byteLength(page)} bytes, more than ${most_bytes}`);
}
writeFileSync(`${folder}/view.html`, page);
const sizes = ["CORE", "MAIN", "WORKER", "LICENCES"].map((name) => `${name.toLowerCase()} ${Buffer.byteLength(parts[name])}`);
console.log(`${folder}/view.html: ${Buffer.byteLength(page)} bytes (${sizes.join(", ")})`);

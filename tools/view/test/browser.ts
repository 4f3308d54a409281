// What the tests stand on: the tool, meshes, a browser, and a page in it that is watched.
import { execFileSync } from "node:child_process";
import { existsSync, readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { chromium, type Browser, type Page } from "playwright-core";

export const [, , page_path = "", tool_path = "", folder = ""] = process.argv;

export function skip(reason: string): never {
    console.log(`skipped: ${reason}`);
    process.exit(77);
}

let checks = 0;
export const checked = () => checks;
export function check(right: boolean, what: string, found?: unknown): void {
    checks += 1;
    if (!right) {
        throw new Error(`${what}${found === undefined ? "" : `: ${JSON.stringify(found)}`}`);
    }
}
export const equal = (found: unknown, wanted: unknown, what: string) =>
    check(JSON.stringify(found) === JSON.stringify(wanted), `${what}: ${JSON.stringify(found)} and not ${JSON.stringify(wanted)}`);

export const at = (name: string) => join(folder, name);
export const tool = (...words: string[]) => execFileSync(tool_path, words, { encoding: "utf8", cwd: folder, maxBuffer: 1 << 28 });
export const hash_in = (text: string) => /^hash +([0-9a-f]{16})$/m.exec(text)?.[1] ?? "none";

export function make(shape: string, triangles: number, name: string): string {
    existsSync(at(name)) || tool("make", shape, "--triangles", String(triangles), "-o", at(name));
    return at(name);
}

/// Boxes as binary STL: x, y, z from and to; without `lacking` triangles at the end.
export function boxes(name: string, all: number[][], lacking = 0): string {
    const faces = [[0, 2, 1], [1, 2, 3], [4, 5, 6], [5, 7, 6], [0, 1, 4], [1, 5, 4], [2, 6, 3], [3, 6, 7], [0, 4, 2], [2, 4, 6], [1, 3, 5], [3, 7, 5]];
    const triangles = all.flatMap((box) => faces.map((face) => face.flatMap((corner) => [0, 1, 2].map((axis) => box[axis + 3 * ((corner >> axis) & 1)]!))));
    const kept = triangles.slice(0, triangles.length - lacking), bytes = Buffer.alloc(84 + 50 * kept.length);
    bytes.writeUInt32LE(kept.length, 80);
    kept.forEach((numbers, t) => numbers.forEach((number, i) => bytes.writeFloatLE(number, 84 + 50 * t + 12 + 4 * i)));
    writeFileSync(at(name), bytes);
    return at(name);
}

export async function launch(): Promise<Browser> {
    const program = process.env["CHROMIUM"] ?? "/usr/bin/chromium";
    existsSync(program) || skip(`${program} is missing; as root: apt-get install chromium`);
    const args = ["--no-sandbox", "--disable-dev-shm-usage", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
        "--force-color-profile=srgb", "--font-render-hinting=none", "--disable-lcd-text"];
    return chromium.launch({ executablePath: program, args });
}

/// A page that may reach nothing, and in which nothing may go wrong unseen.
export async function open_page(browser: Browser, path = page_path, scheme: "light" | "dark" = "light", link = ""): Promise<Page> {
    const context = await browser.newContext({ viewport: { width: 1280, height: 720 }, colorScheme: scheme, acceptDownloads: true });
    await context.setOffline(true);
    const page = await context.newPage();
    page.on("request", (request) => {
        const url = request.url();
        url === `file://${path}` || /^(blob:|data:,$)/.test(url) || wrong.push(`a request: ${url.slice(0, 100)}`);
    });
    page.on("pageerror", (error) => wrong.push(`an error: ${error.message}`));
    page.on("console", (message) => message.type() === "error" && wrong.push(`on the console: ${message.text()}`));
    page.on("dialog", (dialog) => wrong.push(`a dialog: ${dialog.message()}`));
    await page.goto(`file://${path}${link}`);
    await page.waitForSelector("body[data-ready]");
    return page;
}
export const wrong: string[] = [];

/// Files dropped onto the page, as from a desktop.
export async function drop(page: Page, ...paths: string[]): Promise<void> {
    const files = paths.map((path) => ({ name: path.replace(/.*\//, ""), bytes: readFileSync(path).toString("base64") }));
    await page.evaluate((given) => {
        const transfer = new DataTransfer();
        for (const { name, bytes } of given) {
            transfer.items.add(new File([Uint8Array.from(atob(bytes), (c) => c.charCodeAt(0))], name));
        }
        document.body.dispatchEvent(new DragEvent("drop", { dataTransfer: transfer, bubbles: true, cancelable: true }));
    }, files);
}

export async function hash_of(page: Page): Promise<string> {
    await page.waitForSelector("body[data-hash]", { timeout: 120_000 });
    return page.evaluate(() => document.body.dataset["hash"]!);
}

/// The page's state: what main.ts shows to tests.
export const ask = <T>(page: Page, expression: string) => page.evaluate((text) => (0, eval)(text) as T, `(({state, client, go}) => (${expression}))(lamella)`);

export async function go(page: Page, layer: number): Promise<void> {
    await ask(page, `void go(${layer})`);
    await page.waitForSelector(`body[data-layer="${layer}"]`);
}

export async function until(page: Page, expression: string, what: string, ms = 30_000): Promise<void> {
    const end = Date.now() + ms;
    while (!(await ask<boolean>(page, expression))) {
        if (Date.now() > end) {
            throw new Error(`${what} did not come within ${ms} ms`);
        }
        await new Promise((resolve) => setTimeout(resolve, 20));
    }
}

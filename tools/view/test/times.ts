// node times.js PAGE TOOL FOLDER: how long the page takes, for bench/README.md. Prints a table; nothing here passes or fails.
import { statSync } from "node:fs";
import type { Page } from "playwright-core";
import { ask, hash_of, launch, make, open_page, page_path, until } from "./browser";

const share = (times: number[], of: number) => times.sort((a, b) => a - b)[Math.min(times.length - 1, Math.floor(of * times.length))]!;

interface Shown {
    lamella: { go(layer: number): void; state: { slabs: Float64Array; islands_upto: number; layer: { index: number; ms: number }; draw_ms: number } };
    longest: number;
}

/// Milliseconds of each of 300 moves in the worker and on the page, after 30 to warm.
async function moves(page: Page): Promise<string> {
    const times = await page.evaluate(async () => {
        const { go, state } = (globalThis as never as Shown).lamella, found: [number, number][] = [];
        for (let i = 0; i < 330; ++i) {
            const layer = (i * 7919 + 1) % (state.slabs.length / 2);
            go(layer);
            do {
                await new Promise((resolve) => requestAnimationFrame(resolve));
            } while (state.layer.index !== layer);
            await new Promise((resolve) => setTimeout(resolve, 0));
            i >= 30 && found.push([state.layer.ms, state.draw_ms]);
        }
        return found;
    });
    const of = (which: 0 | 1) => [0.5, 0.95].map((part) => share(times.map((pair) => pair[which]), part).toFixed(1)).join(", ");
    return `worker ${of(0)}; page ${of(1)} (ms: p50, p95 of 300 moves)`;
}

const browser = await launch();
console.log(`page: ${statSync(page_path).size} bytes; Chromium ${browser.version()}`);
const page = await open_page(browser);
await page.evaluate(() => {
    const shown = globalThis as never as Shown;
    shown.longest = 0;
    new PerformanceObserver((list) => list.getEntries().forEach(({ duration }) => (shown.longest = Math.max(duration, shown.longest)))).observe({ entryTypes: ["longtask"] });
});
await page.keyboard.press("v"); // the layer alone
const begin = Date.now();
await page.setInputFiles("#file", make("bone", 1_000_000, "million.stl"));
await page.waitForSelector("body[data-layer]");
const first = Date.now() - begin;
await hash_of(page);
console.log(`1 M triangles: first layer after ${first} ms, all ${await ask(page, "state.slabs.length / 2")} after ${Date.now() - begin} ms`);
await until(page, "state.islands_upto === state.slabs.length / 2", "the islands", 120_000);
console.log(`non-zero: ${await moves(page)}`);
await page.selectOption("#rule", "0");
await until(page, "state.plan.rule === 0 && state.islands_upto === state.slabs.length / 2", "the islands", 120_000);
console.log(`contours: ${await moves(page)}`);
const again = Date.now();
await page.evaluate(() => void ((globalThis as never as Shown).longest = 0));
await page.fill("#height", "0.03");
await until(page, "state.slabs.length > 8000", "the layers");
const planned = Date.now() - again;
await hash_of(page);
console.log(`${await ask(page, "state.slabs.length / 2")} layers: planned after ${planned} ms, all after ${Date.now() - again} ms, longest task ${await page.evaluate("longest")} ms`);
await browser.close();

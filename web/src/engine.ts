// Workers that compute, each with a queue in which a newer call replaces an older one of its kind.

import type { Call, Reply, Request, Result, Start, What } from "./messages";

export interface Watcher {
  /** Called when a worker starts or ends its work. */
  busy(): void;
  progress(task: string, done: number, total: number): void;
  /** Called when an internal error ended a worker. */
  broken(): void;
}

interface Job {
  call: Call;
  done: (result: Result) => void;
  failed: (message: string) => void;
}

/** One worker. Calls run in the order of their kinds; of several calls of one kind the last one runs. */
export class Lane {
  private start?: () => Worker;
  private worker?: Worker;
  private readonly waiting = new Map<What, Job>();
  private running?: { id: number; job: Job };
  private count = 0;

  constructor(
    start: Promise<() => Worker>,
    private readonly watcher: Watcher,
    private readonly order: What[],
  ) {
    const begin = (start: () => Worker) => {
      this.start = start;
      this.next();
    };
    // The page reports a module that does not compile.
    start.then(begin, () => undefined);
  }

  get busy(): boolean {
    return this.running !== undefined;
  }

  call(call: Call, done: Job["done"], failed: Job["failed"]) {
    this.waiting.set(call.what, { call, done, failed });
    this.next();
  }

  /** Removes waiting calls of a kind. */
  drop(what: What) {
    this.waiting.delete(what);
  }

  /** Ends the worker and forgets its calls. The next call starts a new one. */
  cancel() {
    this.worker?.terminate();
    this.worker = undefined;
    this.running = undefined;
    this.waiting.clear();
    this.watcher.busy();
  }

  private next() {
    if (this.running || !this.start) return;
    const what = this.order.find((what) => this.waiting.has(what));
    const job = what && this.waiting.get(what);
    if (!what || !job) return;
    this.waiting.delete(what);
    if (!this.worker) {
      this.worker = this.start();
      this.worker.onmessage = ({ data }: MessageEvent<Reply>) => this.receive(data);
    }
    this.running = { id: ++this.count, job };
    this.worker.postMessage({ id: this.count, call: job.call } satisfies Request);
    this.watcher.busy();
  }

  private receive(reply: Reply) {
    if ("progress" in reply) {
      const { task, done, total } = reply.progress;
      this.watcher.progress(task, done, total);
      return;
    }
    if (reply.id !== this.running?.id) return;
    const { job } = this.running;
    this.running = undefined;
    if ("error" in reply) {
      if (reply.broken) {
        this.cancel();
        this.watcher.broken();
      }
      job.failed(reply.error);
    } else {
      job.done(reply.result);
    }
    this.next();
    this.watcher.busy();
  }
}

/** Returns a function that starts workers from a script and a module that the page contains: gzipped, in base64. */
export async function workers(script: string, base64: string): Promise<() => Worker> {
  // The page appears first.
  await new Promise((appeared) => setTimeout(appeared));
  const text = atob(base64);
  const packed = new Uint8Array(text.length);
  for (let i = 0; i < packed.length; i++) packed[i] = text.charCodeAt(i);
  const bytes = new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"));
  const module = await WebAssembly.compile(await new Response(bytes).arrayBuffer());
  const address = URL.createObjectURL(new Blob([script], { type: "text/javascript" }));
  return () => {
    const worker = new Worker(address);
    worker.postMessage({ module } satisfies Start);
    return worker;
  };
}

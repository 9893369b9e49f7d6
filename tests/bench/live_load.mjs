// Live sessions under load, over HTTP alone:
//   QRAYD=$PWD/build/release/bin/qrayd node tests/bench/live_load.mjs shares [seconds]
// four sessions and a job at once: what each gets of what it gets alone, a fifth being fair.
//   QRAYD=... QRAY_E2E_MS=4000000 node tests/bench/live_load.mjs leak [minutes]
// a session that flies, and the server's memory and files each minute; then sessions closed again.
import { setTimeout as sleep } from 'node:timers/promises';
import { scratch_folder, Server } from '../e2e/support.mjs';

const [what = 'shares', amount] = process.argv.slice(2);
const kHeaderBytes = 88;

// A session that flies to and fro until it is closed; counts frames, paths and rays.
class Flight {
  frames = 0;
  paths = 0;
  rays = 0;
  width = 0;
  #abort = new AbortController();

  static async open(server, size = 512) {
    const flight = new Flight();
    flight.server = server;
    flight.info = await server.call('POST', '/v1/live',
      { scene: 'thesis-room', width: size, height: size, frame_ms: 100 });
    flight.reading = flight.#read().catch(() => {});
    flight.flying = flight.#fly();
    return flight;
  }

  async close() {
    this.#abort.abort();
    await this.reading;
    await this.flying;
  }

  async #fly() {
    for (let number = 1; !this.#abort.signal.aborted; ++number) {
      const t = number / 30;
      await this.server.call('PUT', `/v1/live/${this.info.id}/camera`, { number,
        camera: { target: [0.2 * Math.cos(t), 1, -1],
          position: [0.6 * Math.sin(t), 1.45 + 0.2 * Math.sin(t / 2), 2 + 0.3 * Math.cos(t)] } });
      await sleep(50);
    }
  }

  async #read() {
    const answer = await fetch(`${this.server.url}/v1/live/${this.info.id}/frames`,
      { signal: this.#abort.signal });
    let bytes = Buffer.alloc(0);
    for await (const chunk of answer.body) {
      bytes = Buffer.concat([bytes, chunk]);
      while (bytes.length >= kHeaderBytes) {
        const end = kHeaderBytes + bytes.readUInt32LE(8);
        if (bytes.length < end) break;
        ++this.frames;
        this.width += (bytes.readUInt32LE(32) * bytes[15]) / 100;
        this.paths += Number(bytes.readBigUInt64LE(72));
        this.rays += Number(bytes.readBigUInt64LE(80));
        bytes = bytes.subarray(end);
      }
    }
  }
}

// What flights and a job did in `seconds`, a second.
async function rates(server, flights, job, seconds) {
  await sleep(3000); // until budgets have settled
  const count = async () => ({
    flights: flights.map(({ frames, rays, width }) => ({ frames, rays, width })),
    samples: job ? (await server.job(job)).progress.samples : 0,
  });
  const before = await count();
  await sleep(seconds * 1000);
  const after = await count();
  return {
    flights: after.flights.map((now, i) => ({
      frames: (now.frames - before.flights[i].frames) / seconds,
      rays: (now.rays - before.flights[i].rays) / seconds,
      width: (now.width - before.flights[i].width) /
        Math.max(1, now.frames - before.flights[i].frames),
    })),
    samples: (after.samples - before.samples) / seconds,
  };
}

const post_job = (server) => server.post({ scene: 'thesis-room', width: 256, height: 256,
  samples: 100000, learning_samples: 0, method: 'none' });

async function shares(server, seconds) {
  const alone_flight = await Flight.open(server);
  const alone = (await rates(server, [alone_flight], null, seconds)).flights[0];
  await alone_flight.close();
  let job = await post_job(server);
  const job_alone = (await rates(server, [], job, seconds)).samples;
  await server.call('POST', `/v1/jobs/${job}/cancel`);
  await sleep(2000);

  const flights = [];
  for (let i = 0; i < 4; ++i) flights.push(await Flight.open(server));
  job = await post_job(server);
  const all = await rates(server, flights, job, seconds);
  for (const flight of flights) await flight.close();
  const row = (name, frames, rays, width, share) => console.log(
    `${name.padEnd(16)} ${String(frames).padStart(9)} ${String(rays).padStart(9)} ` +
    `${String(width).padStart(6)} ${share}`);
  row('', 'frames/s', 'Mrays/s', 'width', 'of a fifth of alone, by rays');
  row('session, alone', alone.frames.toFixed(1), (alone.rays / 1e6).toFixed(2),
    alone.width.toFixed(0), '');
  all.flights.forEach((f, i) => row(`session ${i + 1} of 4`, f.frames.toFixed(1),
    (f.rays / 1e6).toFixed(2), f.width.toFixed(0), (f.rays / (alone.rays / 5)).toFixed(2)));
  console.log(`job: ${job_alone.toFixed(1)} samples a pixel and second alone, ` +
    `${all.samples.toFixed(1)} with four sessions: ${(all.samples / (job_alone / 5)).toFixed(2)} ` +
    'of a fifth');
}

async function leak(server, minutes) {
  const measure = async (name) => {
    const text = await (await server.get('/metrics')).text();
    const value = (metric) => Number(text.match(new RegExp(`^${metric} (\\S+)`, 'm'))[1]);
    console.log(`${name.padEnd(24)} ${(value('process_resident_memory_bytes') / 2 ** 20)
      .toFixed(1).padStart(7)} MiB ${value('process_open_fds')} files`);
  };
  await measure('start');
  const flight = await Flight.open(server);
  for (let minute = 1; minute <= minutes; ++minute) {
    await sleep(60_000);
    await measure(`${minute} min, ${flight.frames} frames`);
  }
  await flight.close();
  await sleep(2000);
  await measure('closed');
  for (let i = 1; i <= 10; ++i) {
    const more = await Flight.open(server);
    await sleep(2000);
    await more.close();
    await sleep(1800);
    if (i % 5 === 0) await measure(`${i} more sessions`);
  }
}

const server = await Server.start(scratch_folder());
try {
  await (what === 'leak' ? leak : shares)(server, Number(amount ?? (what === 'leak' ? 30 : 10)));
} finally {
  await server.stop();
}

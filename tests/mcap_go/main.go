// Reads MCAP files with Foxglove's own library, as a stream, with the check of every CRC: what a file has, in JSON, a line
// for each file.
package main

import (
	"crypto/sha256"
	"encoding/hex"
	"encoding/json"
	"errors"
	"fmt"
	"io"
	"os"

	"github.com/foxglove/mcap/go/mcap"
)

type report struct {
	Whole      bool              `json:"whole"` // it ends with a footer
	Error      string            `json:"error"` // "": none
	Messages   map[string]uint64 `json:"messages"`
	LastNs     map[string]uint64 `json:"last_ns"`
	Sha256     map[string]string `json:"sha256"` // of all messages of a topic, one after the other
	Statistics map[string]uint64 `json:"statistics"`
}

// look reads records until the file or its sense ends.
func look(file io.Reader) (report, error) {
	out := report{Messages: map[string]uint64{}, LastNs: map[string]uint64{}, Sha256: map[string]string{}}
	topics := map[uint16]string{}
	sums := map[string]interface {
		io.Writer
		Sum([]byte) []byte
	}{}
	defer func() {
		for topic, sum := range sums {
			out.Sha256[topic] = hex.EncodeToString(sum.Sum(nil))
		}
	}()
	lexer, err := mcap.NewLexer(file, &mcap.LexerOptions{ValidateChunkCRCs: true, ComputeAttachmentCRCs: true})
	if err != nil {
		return out, err
	}
	defer lexer.Close()
	for {
		kind, data, err := lexer.Next(nil)
		if errors.Is(err, io.EOF) && out.Whole {
			return out, nil
		}
		if err != nil {
			return out, err
		}
		switch kind {
		case mcap.TokenChannel:
			channel, err := mcap.ParseChannel(data)
			if err != nil {
				return out, err
			}
			topics[channel.ID] = channel.Topic
			if sums[channel.Topic] == nil {
				sums[channel.Topic] = sha256.New()
			}
		case mcap.TokenMessage:
			message, err := mcap.ParseMessage(data)
			if err != nil {
				return out, err
			}
			topic := topics[message.ChannelID]
			out.Messages[topic]++
			out.LastNs[topic] = message.LogTime
			sums[topic].Write(message.Data)
		case mcap.TokenStatistics:
			statistics, err := mcap.ParseStatistics(data)
			if err != nil {
				return out, err
			}
			out.Statistics = map[string]uint64{}
			for id, count := range statistics.ChannelMessageCounts {
				out.Statistics[topics[id]] = count
			}
		case mcap.TokenFooter:
			out.Whole = true
		}
	}
}

func main() {
	for _, name := range os.Args[1:] {
		file, err := os.Open(name)
		if err != nil {
			fmt.Fprintln(os.Stderr, err)
			os.Exit(1)
		}
		out, err := look(file)
		if err != nil {
			out.Error = err.Error()
		}
		_ = file.Close()
		text, err := json.Marshal(out)
		if err != nil {
			fmt.Fprintln(os.Stderr, err)
			os.Exit(1)
		}
		fmt.Println(string(text))
	}
}
